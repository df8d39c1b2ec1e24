//! The robots that are compiled for tests, and the package that compiles each of them. The file uses `modyn_codegen`,
//! `modyn_runtime` and [`random`](crate::random) only, so that a build script can include it.

use std::path::{Path, PathBuf};

use modyn_codegen::{Base, JointFriction, Mimic, ReadOptions, Rotor, read};
use modyn_codegen::{Builder, FloatType, Function, ModuleChoice};
use modyn_runtime::model::{Model, ModuleTree};

use crate::random::{modules, tree, zoo};

/// The source of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The robot of the reference data with this name.
    Golden(&'static str),
    /// The file of `robots/` with this name, without its extension.
    Described(&'static str),
    /// The random tree with this seed and number of links.
    Random(u64, usize),
    /// The random robot with all joint types, this seed and this number of links.
    Zoo(u64, usize),
}

/// The partition of a robot into kinematic modules.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Division {
    /// Maximal serial chains.
    Chains,
    /// One module for each link.
    Links,
    /// A random list with this seed.
    List(u64),
}

/// The package in `tests/fleet/` that compiles a robot. One package is one run of rustc on at most 10 MB of text, for
/// which 3 GB of memory suffice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Small robots; `cargo test --workspace` compiles them.
    Small,
    /// A robot of many joint types with all functions and run-time parameters.
    Parameters,
    /// Large robots with legs.
    Legged,
    /// Random trees of 11 to 30 links.
    Trees,
    /// Robots with all functions.
    Complete,
}

impl Part {
    /// All parts.
    pub const ALL: [Self; 5] =
        [Self::Small, Self::Parameters, Self::Legged, Self::Trees, Self::Complete];

    /// Returns the name of the package.
    #[must_use]
    pub fn package(self) -> &'static str {
        match self {
            Self::Small => "modyn-fleet-small",
            Self::Parameters => "modyn-fleet-parameters",
            Self::Legged => "modyn-fleet-legged",
            Self::Trees => "modyn-fleet-trees",
            Self::Complete => "modyn-fleet-complete",
        }
    }
}

/// The source and the options of a compiled robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spec {
    /// The robot.
    pub source: Source,
    /// The package that compiles it.
    pub part: Part,
    /// The partition into modules.
    pub division: Division,
    /// The scalar of the type's own functions.
    pub float: FloatType,
    /// Whether the robot has all functions of one state, and not only the default ones.
    pub all: bool,
    /// Whether the base floats.
    pub floating: bool,
    /// Whether equal limbs share one function.
    pub share: bool,
    /// The friction of the joints.
    pub friction: JointFriction,
    /// The rotors: joint, inertia and gear ratio.
    pub rotors: &'static [(&'static str, f64, f64)],
    /// The links with run-time inertias; if there are any, gravity is an argument, too.
    pub loaded: &'static [&'static str],
}

use Division::{Chains, Links, List};
use FloatType::{F32, F64};
use Part::{Complete, Legged, Parameters, Trees};
use Source::{Described, Golden, Random, Zoo};

/// All robots. A few of them make up most of the text: `cargo test --workspace` compiles [`Part::Small`]
/// only; the feature `whole` of the package `modyn-fleet` adds the others.
pub const FLEET: &[Spec] = &[
    spec(Golden("double_pendulum"), Chains, F64).all(),
    spec(Golden("double_pendulum_continuous"), Links, F64),
    spec(Golden("double_pendulum"), Links, F64).floating().all().part(Complete),
    spec(Golden("ur5"), Chains, F64),
    spec(Golden("panda"), Links, F64).all().part(Complete),
    spec(Golden("panda"), Chains, F64).loaded(&["panda_hand", "panda_link4"]),
    spec(Golden("panda_fingers"), Chains, F64),
    spec(Golden("solo12"), Chains, F64),
    spec(Golden("solo12"), Chains, F64).floating().part(Legged),
    spec(Golden("g1"), Chains, F64).part(Legged),
    spec(Golden("g1"), Chains, F64).floating().part(Legged),
    spec(Described("gripper"), Chains, F64),
    spec(Described("double_pendulum"), Links, F32),
    spec(Described("arm6"), Chains, F64),
    spec(Described("arm7"), List(1), F32),
    spec(Described("quadruped"), List(2), F64),
    spec(Described("humanoid"), Links, F64).part(Legged),
    spec(Golden("solo12"), Chains, F64).shared(),
    spec(Golden("solo12"), Chains, F64).floating().shared().part(Legged),
    spec(Golden("g1"), Chains, F64).floating().shared().part(Legged),
    spec(Described("quadruped"), Links, F64).floating().shared(),
    spec(Described("mimic_gripper"), Chains, F64).resisted(JointFriction::Coulomb),
    spec(Described("mimic_gripper"), Links, F64)
        .floating()
        .resisted(JointFriction::Coulomb)
        .all()
        .part(Complete),
    spec(Described("four_bar"), Chains, F64),
    spec(Described("joint_zoo"), Chains, F64)
        .resisted(JointFriction::Smooth(0.02))
        .driven(&[("elbow", 2e-5, 80.0), ("glide", 0.01, 3.0)]),
    // Sharing of limbs changes nothing here; the name differs from that of the robot above.
    spec(Described("joint_zoo"), Chains, F64)
        .resisted(JointFriction::Smooth(0.02))
        .driven(&[("elbow", 2e-5, 80.0), ("glide", 0.01, 3.0)])
        .shared()
        .all()
        .part(Complete),
    spec(Random(0, 1), Chains, F64),
    spec(Random(1, 1), Links, F32),
    spec(Random(2, 2), Chains, F64),
    spec(Random(3, 2), List(3), F32).all(),
    spec(Random(4, 3), Chains, F64),
    spec(Random(5, 3), Links, F64),
    spec(Random(6, 4), List(6), F64),
    spec(Random(7, 4), Chains, F32),
    spec(Random(8, 5), Links, F64),
    spec(Random(9, 5), List(9), F64),
    spec(Random(10, 6), Chains, F64).all().part(Complete),
    spec(Random(11, 7), List(11), F32).part(Trees),
    spec(Random(12, 8), Links, F64).part(Trees),
    spec(Random(13, 9), Chains, F64).part(Trees),
    spec(Random(14, 10), List(14), F64).part(Trees),
    spec(Random(15, 12), Chains, F64).part(Trees),
    spec(Random(16, 16), List(16), F64).part(Trees),
    spec(Random(17, 30), Chains, F64).part(Trees),
    spec(Zoo(7423, 7), Links, F32),
    spec(Zoo(10153, 8), List(18), F64).loaded(&["fixed6", "link2"]).all().part(Parameters),
];

const fn spec(source: Source, division: Division, float: FloatType) -> Spec {
    let (friction, rotors, loaded): (_, &[_], &[_]) = (JointFriction::None, &[], &[]);
    let (all, floating, share) = (false, false, false);
    Spec {
        source,
        part: Part::Small,
        division,
        float,
        all,
        floating,
        share,
        friction,
        rotors,
        loaded,
    }
}

impl Spec {
    const fn part(mut self, part: Part) -> Self {
        self.part = part;
        self
    }

    const fn all(mut self) -> Self {
        self.all = true;
        self
    }

    const fn floating(mut self) -> Self {
        self.floating = true;
        self
    }

    const fn shared(mut self) -> Self {
        self.share = true;
        self
    }

    const fn resisted(mut self, friction: JointFriction) -> Self {
        self.friction = friction;
        self
    }

    const fn driven(mut self, rotors: &'static [(&'static str, f64, f64)]) -> Self {
        self.rotors = rotors;
        self
    }

    const fn loaded(mut self, links: &'static [&'static str]) -> Self {
        self.loaded = links;
        self
    }

    /// Returns the robot's description file, if there is one.
    fn file(&self) -> Option<PathBuf> {
        let file = match self.source {
            Golden(name) => format!("tests/golden/{name}.urdf"),
            Described(name) => format!("robots/{name}.urdf"),
            Random(..) | Zoo(..) => return None,
        };
        // The packages that include this file are in folders of different depths.
        let mut folders = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
        folders.find_map(|folder| Some(folder.join(&file)).filter(|file| file.is_file()))
    }

    /// Returns all functions of one state; functions of many states have tests of their own.
    pub fn all_functions() -> impl Iterator<Item = Function> {
        Function::ALL.iter().copied().filter(|function| function.batched().is_none())
    }

    /// Returns the name that [`Builder::compile`] gives the text in `OUT_DIR`, without the extension.
    #[must_use]
    pub fn module(&self) -> String {
        let name = match self.source {
            Golden(name) => format!("golden_{name}"),
            Described(name) => name.into(),
            Random(seed, links) => format!("tree{seed}_{links}"),
            Zoo(seed, links) => format!("zoo{seed}_{links}"),
        };
        let floating = if self.floating { "_floating" } else { "" };
        let loaded = if self.loaded.is_empty() { "" } else { "_loaded" };
        let shared = if self.share { "_shared" } else { "" };
        format!("{name}{floating}{loaded}{shared}")
    }

    /// Returns the mimic option: that of the reference data, or the default one of descriptions.
    fn mimic(&self) -> Mimic {
        if matches!(self.source, Golden(_)) { Mimic::Independent } else { Mimic::Follow }
    }

    fn base(&self) -> Base {
        if self.floating { Base::Floating } else { Base::Fixed }
    }

    /// Returns the robot's model.
    ///
    /// # Panics
    ///
    /// Panics if the description cannot be read.
    #[must_use]
    pub fn model(&self) -> Model {
        let file = match (self.file(), self.source) {
            (Some(file), _) => file,
            (None, Random(seed, links)) => return tree(seed, links),
            (None, Zoo(seed, links)) => {
                let model = zoo(seed, links);
                if self.loaded.is_empty() {
                    return model;
                }
                // Payloads are not compensated, but the tests compare them with inertias of links.
                return model.with_gravity_compensation(Vec::new()).expect("no factors");
            }
            (None, source) => panic!("there is no file of {source:?}"),
        };
        let name = file.display().to_string();
        let text = std::fs::read_to_string(&file).unwrap_or_else(|error| panic!("{name}: {error}"));
        let rotor = |&(joint, inertia, gear_ratio): &(&str, f64, f64)| Rotor {
            joint: joint.into(),
            inertia,
            gear_ratio,
        };
        let options = ReadOptions {
            mimic: self.mimic(),
            base: self.base(),
            joint_friction: Some(self.friction),
            rotors: self.rotors.iter().map(rotor).collect(),
            ..ReadOptions::default()
        };
        read(&text, &name, &options).unwrap_or_else(|errors| panic!("{errors}")).model
    }

    /// Returns the modules of `model`, which is this robot's model.
    #[must_use]
    pub fn modules(&self, model: &Model) -> ModuleTree {
        match self.division {
            Chains => ModuleTree::chains(model),
            Links => ModuleTree::links(model),
            List(seed) => modules(seed, model),
        }
    }

    /// Returns the builder that compiles the robot: descriptions by their path, random robots by their model.
    #[must_use]
    pub fn builder(&self) -> Builder {
        let model = self.model();
        let mut builder = Builder::new().scalar(self.float).modules(match self.division {
            Chains => ModuleChoice::Chains,
            Links => ModuleChoice::Links,
            List(_) => {
                let name = |i: usize| model.moving_links()[i].name.clone();
                let tree = self.modules(&model);
                let lists = tree.modules().iter().map(|module| module.links.clone().map(name));
                ModuleChoice::List(lists.map(Iterator::collect).collect())
            }
        });
        builder = match self.file() {
            Some(file) => {
                let file = builder.urdf(file).mimic(self.mimic()).base(self.base());
                let rotors = self.rotors.iter().map(|rotor| Rotor::new(rotor.0, rotor.1, rotor.2));
                file.joint_friction(self.friction).rotors(rotors)
            }
            None => builder.model(model),
        };
        if self.share {
            builder = builder.share_limbs();
        }
        if self.all {
            builder = builder.functions(Self::all_functions());
        }
        if !self.loaded.is_empty() {
            let links = || self.loaded.iter().copied();
            builder = builder.runtime_inertia(links()).payload(links()).runtime_gravity();
        }
        match self.source {
            // The builder derives the name from the description.
            Described(name) if name == self.module() => builder,
            _ => builder.type_name(modyn_codegen::names::type_name(&self.module())),
        }
    }
}
