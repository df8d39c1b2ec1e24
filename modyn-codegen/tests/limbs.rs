//! Equal limbs in vectors give the results of limbs computed one after the other, with fewer operations.

use modyn_codegen::graph::{Expr, Graph};
use modyn_codegen::passes::optimize;
use modyn_codegen::plan::LIMB_LIMITS;
use modyn_codegen::trace::{LimbPacking, Parameters, Tracer};
use modyn_codegen::{Base, ReadOptions};
use modyn_runtime::equations::ModulePartition;
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::dynamics::Elimination;
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::{Model, ModuleTree};
use modyn_runtime::{LaneScalar, Scalar};

/// Three fingers with the same joints and different constants on a rotating palm, and a thumb.
const HAND: &str = r#"
<robot name="hand">
  <link name="world">MASS</link>
  <joint name="wrist" type="revolute"><parent link="world"/><child link="palm"/><axis xyz="0 0.6 0.8"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <link name="palm">MASS</link>
  FINGER(a, 0.1 0 0.2, 0.4 0 0, 0.02)
  FINGER(b, 0 0.1 0.2, 0 1.5707963267948966 0, 0.03)
  <joint name="thumb" type="prismatic"><parent link="palm"/><child link="thumb_tip"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <link name="thumb_tip">MASS</link>
  FINGER(c, 0 0 0.3, 0 0 0, 0.04)
</robot>"#;

/// Returns the description of the hand: `MASS` and `FINGER` are replaced by elements.
fn hand() -> String {
    let mass = "<inertial><origin xyz=\"0.01 0.02 0.1\"/><mass value=\"0.3\"/>\
                <inertia ixx=\"0.02\" iyy=\"0.03\" izz=\"0.02\" ixy=\"0.001\" ixz=\"0\" iyz=\"0\"/></inertial>";
    let mut text = String::new();
    for line in HAND.lines() {
        let Some(list) = line.trim().strip_prefix("FINGER(").and_then(|l| l.strip_suffix(')'))
        else {
            text += &line.replace("MASS", mass);
            continue;
        };
        let [name, xyz, rpy, armature] =
            list.split(", ").collect::<Vec<_>>().try_into().expect("four");
        // Some fingers have a rotor at the last joint.
        let rotor = if name == "b" {
            String::new()
        } else {
            format!("<dynamics armature=\"{armature}\"/>")
        };
        text += &format!(
            "<joint name=\"{name}1\" type=\"continuous\"><parent link=\"palm\"/><child link=\"{name}1\"/>\
             <origin xyz=\"{xyz}\" rpy=\"{rpy}\"/><axis xyz=\"1 0 0\"/></joint><link name=\"{name}1\">{mass}</link>\
             <joint name=\"{name}2\" type=\"continuous\"><parent link=\"{name}1\"/><child link=\"{name}2\"/>\
             <origin xyz=\"0 {armature} 0.2\"/><axis xyz=\"0 1 0\"/>{rotor}</joint><link name=\"{name}2\">{mass}</link>"
        );
    }
    text
}

fn read(text: &str, name: &str, base: Base) -> Model {
    let options = ReadOptions { base, ..ReadOptions::default() };
    modyn_codegen::read(text, name, &options).expect("a good robot").model
}

/// Returns robots with equal limbs, and whether their limbs are independent of each other.
fn robots() -> Vec<(&'static str, Model, bool)> {
    let quadruped = include_str!("../../robots/quadruped.urdf");
    let humanoid = include_str!("../../robots/humanoid.urdf");
    vec![
        ("quadruped", read(quadruped, "quadruped", Base::Fixed), true),
        ("floating quadruped", read(quadruped, "quadruped", Base::Floating), false),
        ("humanoid", read(humanoid, "humanoid", Base::Fixed), false),
        ("floating humanoid", read(humanoid, "humanoid", Base::Floating), false),
        ("hand", read(&hand(), "hand", Base::Fixed), false),
        ("floating hand", read(&hand(), "hand", Base::Floating), false),
    ]
}

/// Checks that both graphs have the same outputs; returns the operations of both.
fn compare(name: &str, quantity: &str, alone: Graph, packed: Graph) -> [usize; 2] {
    let (alone, packed) = (optimize(alone), optimize(packed));
    for seed in 0..3 {
        let inputs: Vec<f64> =
            (0..200).map(|i| libm::sin(f64::from(i) * 0.7 + f64::from(seed))).collect();
        let (expected, found) = (alone.evaluate(&inputs), packed.evaluate(&inputs));
        assert_eq!(expected.len(), found.len());
        for (expected, found) in expected.iter().zip(&found) {
            let error = (expected - found).abs() / expected.abs().max(1.0);
            assert!(error < 1e-9, "{quantity} of the {name}: {found} for {expected}");
        }
    }
    [&alone, &packed].map(|graph| graph.count().total())
}

#[test]
fn equal_limbs_side_by_side_give_the_same() {
    for (name, model, independent) in robots() {
        let mechanism = Mechanism::new(&model);
        let limbs = LimbPacking::find(&mechanism, &LIMB_LIMITS).expect("equal limbs");
        assert_eq!(limbs.independent(&mechanism), independent, "{name}");
        let gravity = Tracer::with_parameters(&mechanism, Parameters::new(&model, true, &[], &[]));
        for alone in [Tracer::new(&mechanism), gravity] {
            let packed = alone.packed(&limbs);
            for modules in [ModuleTree::chains(&model), ModuleTree::links(&model)] {
                let partition = ModulePartition::new(&mechanism, &modules);
                let merged = Elimination::Recursive(limbs.partition(&partition));
                let [before, after] = compare(
                    name,
                    "forward dynamics",
                    alone.forward_dynamics(&Elimination::Recursive(partition)),
                    packed.forward_dynamics(&merged),
                );
                assert!(after * 5 < before * 4, "{name}: {before} to {after}");
            }
            let pairs = [
                ("inverse dynamics", alone.inverse_dynamics(), packed.inverse_dynamics()),
                ("bias forces", alone.bias_forces(), packed.bias_forces()),
                ("gravity torques", alone.gravity_torques(), packed.gravity_torques()),
                ("the mass matrix", alone.mass_matrix(), packed.mass_matrix()),
            ];
            for (quantity, alone, packed) in pairs {
                let [before, after] = compare(name, quantity, alone, packed);
                assert!(after < before, "{quantity} of the {name}: {before} to {after}");
            }
            let layout = UduLayout::new(&mechanism, &ModuleTree::chains(&model));
            let pairs = [
                (
                    "inverse dynamics' derivatives",
                    alone.inverse_dynamics_derivatives(),
                    packed.inverse_dynamics_derivatives(),
                ),
                (
                    "forward dynamics' derivatives",
                    alone.forward_dynamics_derivatives(&layout),
                    packed.forward_dynamics_derivatives(&layout),
                ),
            ];
            for (quantity, alone, packed) in pairs {
                let [before, after] = compare(name, quantity, alone, packed);
                assert!(after < before, "{quantity} of the {name}: {before} to {after}");
            }
        }
    }
}

#[test]
fn limbs_on_different_bodies_side_by_side_give_the_same() {
    for (name, model, _) in robots() {
        let mechanism = Mechanism::new(&model);
        let equal = LimbPacking::find(&mechanism, &LIMB_LIMITS).expect("equal limbs");
        let Some(joined) = LimbPacking::joined(&mechanism, &LIMB_LIMITS) else {
            assert!(!name.contains("humanoid"), "{name} has legs and arms");
            continue;
        };
        assert!(name.contains("humanoid"), "{name}");
        let gravity = Tracer::with_parameters(&mechanism, Parameters::new(&model, true, &[], &[]));
        for alone in [Tracer::new(&mechanism), gravity] {
            let (equally, jointly) = (alone.packed(&equal), alone.packed(&joined));
            for modules in [ModuleTree::chains(&model), ModuleTree::links(&model)] {
                let partition = ModulePartition::new(&mechanism, &modules);
                let merged =
                    |limbs: &LimbPacking| Elimination::Recursive(limbs.partition(&partition));
                let [before, after] = compare(
                    name,
                    "forward dynamics",
                    equally.forward_dynamics(&merged(&equal)),
                    jointly.forward_dynamics(&merged(&joined)),
                );
                assert!(after * 7 < before * 6, "{name}: {before} to {after}");
            }
            let pairs = [
                ("inverse dynamics", equally.inverse_dynamics(), jointly.inverse_dynamics()),
                ("bias forces", equally.bias_forces(), jointly.bias_forces()),
                ("gravity torques", equally.gravity_torques(), jointly.gravity_torques()),
            ];
            for (quantity, equally, jointly) in pairs {
                let [before, after] = compare(name, quantity, equally, jointly);
                assert!(after * 5 < before * 4, "{quantity} of the {name}: {before} to {after}");
            }
            let (equally, jointly) = (equally.mass_matrix(), jointly.mass_matrix());
            let [before, after] = compare(name, "the mass matrix", equally, jointly);
            assert!(after < before, "the mass matrix of the {name}: {before} to {after}");
        }
    }
}

/// Returns a robot with two limbs of `low` joints on a trunk, then a waist and two limbs of `high` joints on the torso.
fn upright(low: usize, high: usize) -> String {
    let mass = |x: f64| {
        format!(
            "<inertial><origin xyz=\"0.01 {x} 0.1\"/><mass value=\"{x}\"/>\
             <inertia ixx=\"0.2\" iyy=\"0.3\" izz=\"0.2\" ixy=\"0.01\" ixz=\"0\" iyz=\"0\"/></inertial>"
        )
    };
    let mut text = format!("<robot name=\"upright\"><link name=\"trunk\">{}</link>", mass(0.9));
    let mut add = |name: String, parent: String, axis: &str, x: f64| {
        text += &format!(
            "<joint name=\"{name}_joint\" type=\"continuous\"><parent link=\"{parent}\"/>\
             <child link=\"{name}\"/><origin xyz=\"{x} 0.1 0.3\" rpy=\"{x} 0 0.1\"/><axis xyz=\"{axis}\"/>\
             <dynamics damping=\"{x}\" armature=\"{x}\"/></joint><link name=\"{name}\">{}</link>",
            mass(0.4 + x)
        );
    };
    for (side, trunk, joints) in
        [("left_leg", "trunk", low), ("right_leg", "trunk", low), ("waist", "trunk", 1)]
            .into_iter()
            .chain([("left_arm", "waist0", high), ("right_arm", "waist0", high)])
    {
        for k in 0..joints {
            let parent = k.checked_sub(1).map_or(trunk.into(), |k| format!("{side}{k}"));
            let axis = ["0 0 1", "1 0 0", "0 1 0"][k % 3];
            add(format!("{side}{k}"), parent, axis, 0.1 + 0.03 * (side.len() + k) as f64);
        }
    }
    text + "</robot>"
}

#[test]
fn limbs_that_join_may_be_longer_or_shorter_above() {
    let options = |base| ReadOptions {
        base,
        joint_friction: Some(modyn_codegen::JointFriction::Viscous),
        ..ReadOptions::default()
    };
    for (low, high) in [(2, 4), (4, 2), (3, 3), (2, 3)] {
        for base in [Base::Fixed, Base::Floating] {
            let read = modyn_codegen::read(&upright(low, high), "upright", &options(base));
            let model = read.expect("a good robot").model;
            let mechanism = Mechanism::new(&model);
            let joined =
                LimbPacking::joined(&mechanism, &LIMB_LIMITS).expect("limbs that can join");
            let alone = Tracer::new(&mechanism);
            let packed = alone.packed(&joined);
            for modules in [ModuleTree::chains(&model), ModuleTree::links(&model)] {
                let partition = ModulePartition::new(&mechanism, &modules);
                let merged = Elimination::Recursive(joined.partition(&partition));
                let name = format!("upright {low} {high}");
                compare(
                    &name,
                    "forward dynamics",
                    alone.forward_dynamics(&Elimination::Recursive(partition)),
                    packed.forward_dynamics(&merged),
                );
                let layout = UduLayout::new(&mechanism, &modules);
                compare(
                    &name,
                    "forward dynamics' derivatives",
                    alone.forward_dynamics_derivatives(&layout),
                    packed.forward_dynamics_derivatives(&layout),
                );
            }
            assert!(joined.share_root_path(&mechanism));
            for (quantity, alone, packed) in [
                ("torques", alone.inverse_dynamics(), packed.inverse_dynamics()),
                ("gravity", alone.gravity_torques(), packed.gravity_torques()),
                ("the mass matrix", alone.mass_matrix(), packed.mass_matrix()),
                (
                    "inverse dynamics' derivatives",
                    alone.inverse_dynamics_derivatives(),
                    packed.inverse_dynamics_derivatives(),
                ),
            ] {
                compare("upright", quantity, alone, packed);
            }
        }
    }
    // Three further joints cost more than the vectors gain.
    let read = modyn_codegen::read(&upright(2, 5), "upright", &ReadOptions::default());
    assert_eq!(
        LimbPacking::joined(&Mechanism::new(&read.expect("a good robot").model), &LIMB_LIMITS),
        None
    );
}

/// Packed forward dynamics computes what scalar forward dynamics does, by each choice of modules, in fewer operations.
#[test]
fn packed_forward_dynamics_is_scalar_forward_dynamics() {
    let modules = [ModuleTree::chains as fn(&Model) -> _, ModuleTree::links];
    let mut rows = 0;
    for (name, model, _) in robots() {
        let mechanism = Mechanism::new(&model);
        let limbs = LimbPacking::find(&mechanism, &LIMB_LIMITS).expect("equal limbs");
        for modules in modules {
            let partition = ModulePartition::new(&mechanism, &modules(&model));
            let merged = Elimination::Recursive(limbs.partition(&partition));
            let alone = Tracer::new(&mechanism);
            let [before, after] = compare(
                name,
                "forward dynamics",
                alone.forward_dynamics(&Elimination::Recursive(partition.clone())),
                alone.packed(&limbs).forward_dynamics(&merged),
            );
            assert!(after < before, "{name}: {before}, {after}");
            rows += 1;
        }
    }
    assert!(rows >= 5, "{rows}");
}

#[test]
fn robots_without_equal_limbs_are_not_packed() {
    let arm = read(include_str!("../../robots/arm7.urdf"), "arm7", Base::Fixed);
    assert_eq!(LimbPacking::find(&Mechanism::new(&arm), &LIMB_LIMITS), None);
    let mimics = read(include_str!("../../robots/mimic_gripper.urdf"), "gripper", Base::Fixed);
    assert_eq!(LimbPacking::find(&Mechanism::new(&mimics), &LIMB_LIMITS), None);
}

#[test]
fn lanes_are_put_together_and_taken_apart() {
    let graph = Graph::trace(|| {
        let numbers: Vec<Expr> = (0..3).map(Expr::input).collect();
        let constants: Vec<Expr> = [1.0, 2.0, 3.0].map(Expr::from_f64).to_vec();
        let lanes = Expr::pack(&numbers) * Expr::pack(&constants) + Expr::input(3);
        vec![
            lanes.extract_lane(0),
            lanes.extract_lane(2),
            lanes.sum_lanes(0..3),
            (-lanes).extract_lane(1),
        ]
    });
    assert_eq!(graph.evaluate(&[2.0, 3.0, 5.0, 7.0]), [9.0, 22.0, 44.0, -13.0]);
    // A product and a sum of four lanes each, and a sum over three lanes.
    assert_eq!(graph.count().total(), 4);
}

#[test]
fn lanes_of_constants_are_folded() {
    let graph = Graph::trace(|| {
        let [a, b] =
            [[1.0, 2.0], [3.0, 5.0]].map(|numbers| Expr::pack(&numbers.map(Expr::from_f64)));
        let sum = a * b + Expr::from_f64(1.0);
        vec![
            sum.extract_lane(0),
            sum.extract_lane(1),
            Expr::pack(&[Expr::input(0); 4]).extract_lane(3),
        ]
    });
    assert_eq!(graph.count().total(), 0);
    assert_eq!(graph.evaluate(&[9.0]), [4.0, 11.0, 9.0]);
}
