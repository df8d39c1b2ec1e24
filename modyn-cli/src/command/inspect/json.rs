//! The output of `modyn inspect --json`.

use modyn_codegen::MAX_CONDITION_F32;
use modyn_runtime::OperationCount;
use modyn_runtime::model::Model;
use serde_json::{Value, json};

use super::text::active_friction;
use super::{Cost, Inspection, actuators, advice};
use crate::command::diagnostics;
use crate::escape;

/// Returns the inspection as JSON, in SI units.
pub fn of(inspection: &Inspection) -> String {
    let Inspection { model, modules, warnings, advice, condition, has_dynamics, costs } =
        inspection;
    let modules: Vec<Value> = modules
        .modules()
        .iter()
        .map(|module| {
            let links = &model.moving_links()[module.links.clone()];
            json!({
                "parent": module.parent,
                "children": module.children,
                "links": links.iter().map(|link| &link.name).collect::<Vec<_>>(),
            })
        })
        .collect();
    let advice: Vec<Value> =
        advice.iter().map(|one| json!({ "link": one.link, "message": one.message })).collect();
    let counted = costs.as_ref().and_then(|costs| costs.as_ref().ok());
    let refused = costs.as_ref().and_then(|costs| costs.as_ref().err());
    let all = json!({
        "usable": true,
        "robot": model.name(),
        "nq": model.nq(),
        "nv": model.nv(),
        "mass": advice::total_mass(model),
        "gravity": model.gravity(),
        "coordinates": model.coordinate_names(),
        "velocities": model.velocity_names(),
        "joints": (0..model.moving_links().len()).map(|i| joint(model, i)).collect::<Vec<_>>(),
        "loops": model.loop_constraints().iter().map(|constraint| json!({
            "name": constraint.name,
            "type": constraint.kind.name(),
            "axis": constraint.kind.axis(),
            "links": constraint.ends.each_ref().map(|end| &model.links()[end.link].name),
        })).collect::<Vec<_>>(),
        "contacts": model.contacts().iter().map(|contact| json!({
            "name": contact.name,
            "type": contact.kind.name(),
            "link": model.links()[contact.end.link].name,
        })).collect::<Vec<_>>(),
        "actuators": actuators::json(model),
        "keyframes": model.keyframes().iter().map(|key| json!({
            "name": key.name,
            "q": key.q,
            "qd": key.qd,
            "ctrl": key.ctrl,
            "act": key.act,
        })).collect::<Vec<_>>(),
        "links": model.moving_links().iter().map(|link| json!({
            "name": link.name,
            "mass": link.inertial.mass,
            "center_of_mass": link.inertial.center_of_mass,
            "principal_moments": link.inertial.principal_moments(),
        })).collect::<Vec<_>>(),
        "modules": modules,
        "has_dynamics": has_dynamics,
        "condition_number": condition.filter(|number| number.is_finite()),
        "f32_will_do": condition.map(|number| number <= MAX_CONDITION_F32),
        "functions": counted.map(|costs| costs.iter().map(cost).collect::<Vec<_>>()),
        "not_compiled": refused.map(|why| diagnostics::to_json(why.as_slice())),
        "diagnostics": diagnostics::to_json(warnings),
        "advice": advice,
    });
    escape::json(&all)
}

fn joint(model: &Model, link: usize) -> Value {
    let moved = &model.moving_links()[link];
    let joint = &moved.joint;
    let q = model.q_range(link);
    let v = model.v_range(link);
    let [damps, rubs] = active_friction(model);
    json!({
        "name": joint.name,
        "type": joint.joint_type.name(),
        "link": moved.name,
        "parent": moved.parent.map(|parent| &model.moving_links()[parent].name),
        "axis": joint.axis,
        "q": [q.start, q.end],
        "v": [v.start, v.end],
        "limits": joint.limits.as_ref().map(|limits| json!({
            "lower": limits.lower,
            "upper": limits.upper,
            "velocity": limits.velocity,
            "effort": limits.effort,
        })),
        "mimic": model.mimic(link).map(|mimic| json!({
            "joint": model.moving_links()[mimic.leader].joint.name,
            "multiplier": mimic.multiplier,
            "offset": mimic.offset,
        })),
        "armature": joint.dynamics.armature,
        "spring": model.spring(link).map(|spring| json!({
            "stiffness": spring.stiffness,
            "reference": spring.reference,
        })),
        "damping": joint.dynamics.damping,
        "friction": joint.dynamics.friction,
        "damping_acts": damps,
        "friction_acts": rubs,
    })
}

fn cost(Cost { name, operations, bytes, loops }: &Cost) -> Value {
    let OperationCount { multiplications, additions, divisions, sin_cos, others } = operations;
    json!({
        "name": name,
        "multiplications": multiplications,
        "additions": additions,
        "divisions": divisions,
        "sin_cos": sin_cos,
        "others": others,
        "operations": operations.total(),
        "estimated_code_bytes": bytes.map(f64::round),
        "loops": loops,
    })
}
