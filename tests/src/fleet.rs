//! The robots that are compiled for tests, and the package that compiles each of them. Needs `modyn_codegen`,
//! `modyn_runtime` and [`random`](crate::random) alone, so that a build script can include this file.

use std::path::{Path, PathBuf};

use modyn_codegen::{Base, Friction, Mimic, ReadOptions, Rotor, read};
use modyn_codegen::{Builder, FloatType, Function, ModuleChoice};
use modyn_runtime::model::{Model, ModuleTree};

use crate::random::{modules, tree, zoo};

/// Where a robot comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The reference data's robot of that name.
    Golden(&'static str),
    /// That file of `robots/`, without its extension.
    Described(&'static str),
    /// The random tree of that seed and that many links.
    Random(u64, usize),
    /// The random robot with all joint types of that seed and that many links.
    Zoo(u64, usize),
}

/// How a robot is divided into kinematic modules.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Division {
    /// Maximal serial chains.
    Chains,
    /// Every link its own module.
    Links,
    /// A list at random, of that seed.
    List(u64),
}

/// The package in `tests/fleet/` that compiles a robot. One package is one run of rustc, on at most
/// 10 MB of text: then 3 GB of memory suffice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Small robots, which `cargo test --workspace` compiles.
    Small,
    /// Large robots with legs.
    Legged,
    /// Random trees of 11 to 30 links.
    Trees,
    /// Robots with all functions.
    Complete,
}

impl Part {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Small, Self::Legged, Self::Trees, Self::Complete];

    /// The name of its package.
    #[must_use]
    pub fn package(self) -> &'static str {
        match self {
            Self::Small => "modyn-fleet-small",
            Self::Legged => "modyn-fleet-legged",
            Self::Trees => "modyn-fleet-trees",
            Self::Complete => "modyn-fleet-complete",
        }
    }
}

/// A robot as it is compiled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spec {
    /// The robot.
    pub source: Source,
    /// The package that compiles it.
    pub part: Part,
    /// Its modules.
    pub division: Division,
    /// The scalar of the type's own functions.
    pub float: FloatType,
    /// Whether it has all functions of single states, not just the default ones.
    pub all: bool,
    /// Whether its base floats.
    pub floating: bool,
    /// Whether equal limbs run through one function.
    pub share: bool,
    /// What resists its joints.
    pub friction: Friction,
    /// Rotors: joint, inertia and gear ratio.
    pub rotors: &'static [(&'static str, f64, f64)],
    /// The links whose inertia is an argument; gravity is one too if there are any.
    pub loaded: &'static [&'static str],
}

use Division::{Chains, Links, List};
use FloatType::{F32, F64};
use Part::{Complete, Legged, Trees};
use Source::{Described, Golden, Random, Zoo};

/// All of them. Most of the text is that of a few: `cargo test --workspace` compiles [`Part::Small`] alone, and the
/// feature `whole` of the package `modyn-fleet` the others, too.
pub const FLEET: &[Spec] = &[
    spec(Golden("double_pendulum"), Chains, F64).all(),
    spec(Golden("double_pendulum_continuous"), Links, F64),
    spec(Golden("ur5"), Chains, F64).all(),
    spec(Golden("panda"), Links, F64).all().part(Complete),
    spec(Golden("panda"), Chains, F64).loaded(&["panda_hand", "panda_link4"]),
    spec(Golden("panda_fingers"), Chains, F64),
    spec(Golden("solo12"), Chains, F64),
    spec(Golden("solo12"), Chains, F64).floating().all().part(Legged),
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
    spec(Described("mimic_gripper"), Chains, F64).resisted(Friction::Coulomb).all(),
    spec(Described("four_bar"), Chains, F64),
    spec(Described("joint_zoo"), Chains, F64)
        .resisted(Friction::Smooth(0.02))
        .driven(&[("elbow", 2e-5, 80.0), ("glide", 0.01, 3.0)])
        .all(),
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
    spec(Zoo(10153, 8), List(18), F64).loaded(&["fixed6", "link2"]).all(),
];

const fn spec(source: Source, division: Division, float: FloatType) -> Spec {
    let (friction, rotors, loaded): (_, &[_], &[_]) = (Friction::None, &[], &[]);
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

    const fn resisted(mut self, friction: Friction) -> Self {
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

    /// The file that describes the robot, if one does.
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

    /// All functions of single states; batches have tests of their own.
    pub fn all_functions() -> impl Iterator<Item = Function> {
        Function::ALL.iter().copied().filter(|function| function.batched().is_none())
    }

    /// What [`Builder::compile`] calls the text in `OUT_DIR`, without the extension.
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

    /// As the reference data has it, or as a description is taken by default.
    fn mimic(&self) -> Mimic {
        if matches!(self.source, Golden(_)) { Mimic::Independent } else { Mimic::Follow }
    }

    fn base(&self) -> Base {
        if self.floating { Base::Floating } else { Base::Fixed }
    }

    /// The robot.
    ///
    /// # Panics
    ///
    /// If its description cannot be read.
    #[must_use]
    pub fn model(&self) -> Model {
        let file = match (self.file(), self.source) {
            (Some(file), _) => file,
            (None, Random(seed, links)) => return tree(seed, links),
            (None, Zoo(seed, links)) => return zoo(seed, links),
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
            friction: Some(self.friction),
            rotors: self.rotors.iter().map(rotor).collect(),
            ..ReadOptions::default()
        };
        read(&text, &name, &options).unwrap_or_else(|errors| panic!("{errors}")).model
    }

    /// The modules of `model`, which is this robot's.
    #[must_use]
    pub fn modules(&self, model: &Model) -> ModuleTree {
        match self.division {
            Chains => ModuleTree::chains(model),
            Links => ModuleTree::links(model),
            List(seed) => modules(seed, model),
        }
    }

    /// What compiles it: descriptions by their path, random robots by their model.
    #[must_use]
    pub fn builder(&self) -> Builder {
        let model = self.model();
        let mut builder = Builder::new().scalar(self.float).modules(match self.division {
            Chains => ModuleChoice::Chains,
            Links => ModuleChoice::Links,
            List(_) => {
                let name = |i: usize| model.links()[i].name.clone();
                let tree = self.modules(&model);
                let lists = tree.modules().iter().map(|module| module.links.clone().map(name));
                ModuleChoice::List(lists.map(Iterator::collect).collect())
            }
        });
        builder = match self.file() {
            Some(file) => {
                let file = builder.urdf(file).mimic(self.mimic()).base(self.base());
                let rotors = self.rotors.iter().map(|rotor| Rotor::new(rotor.0, rotor.1, rotor.2));
                file.friction(self.friction).rotors(rotors)
            }
            None => builder.model(model),
        };
        if self.share {
            builder = builder.share();
        }
        if self.all {
            builder = builder.functions(Self::all_functions());
        }
        if !self.loaded.is_empty() {
            let links = || self.loaded.iter().copied();
            builder = builder.runtime_inertia(links()).payload(links()).runtime_gravity();
        }
        match self.source {
            // Under the name that its description gives it.
            Described(name) if name == self.module() => builder,
            _ => builder.type_name(modyn_codegen::names::type_name(&self.module())),
        }
    }
}
