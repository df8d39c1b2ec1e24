//! The robots that the build script compiles. Needs `modyn_codegen`, `modyn_runtime` and
//! [`random`](crate::random) alone, so that a build script can include this file.

use std::path::{Path, PathBuf};

use modyn_codegen::urdf::{Mimic, ReadOptions, read};
use modyn_codegen::{Builder, FloatType, ModuleChoice};
use modyn_runtime::model::{Model, ModuleTree};

use crate::random::{modules, tree};

/// Where a robot comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The reference data's robot of that name.
    Golden(&'static str),
    /// That file of `robots/`, without its extension.
    Described(&'static str),
    /// The random tree of that seed and that many links.
    Random(u64, usize),
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

/// A robot as it is compiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spec {
    /// The robot.
    pub source: Source,
    /// Its modules.
    pub division: Division,
    /// The scalar of the type's own functions.
    pub float: FloatType,
}

use Division::{Chains, Links, List};
use FloatType::{F32, F64};
use Source::{Described, Golden, Random};

/// All of them.
pub const FLEET: [Spec; 31] = [
    spec(Golden("double_pendulum"), Chains, F64),
    spec(Golden("double_pendulum_continuous"), Links, F64),
    spec(Golden("ur5"), Chains, F64),
    spec(Golden("panda"), Links, F64),
    spec(Golden("panda_fingers"), Chains, F64),
    spec(Golden("solo12"), Chains, F64),
    spec(Golden("g1"), Chains, F64),
    spec(Described("gripper"), Chains, F64),
    spec(Described("double_pendulum"), Links, F32),
    spec(Described("arm6"), Chains, F64),
    spec(Described("arm7"), List(1), F32),
    spec(Described("quadruped"), List(2), F64),
    spec(Described("humanoid"), Links, F64),
    spec(Random(0, 1), Chains, F64),
    spec(Random(1, 1), Links, F32),
    spec(Random(2, 2), Chains, F64),
    spec(Random(3, 2), List(3), F32),
    spec(Random(4, 3), Chains, F64),
    spec(Random(5, 3), Links, F64),
    spec(Random(6, 4), List(6), F64),
    spec(Random(7, 4), Chains, F32),
    spec(Random(8, 5), Links, F64),
    spec(Random(9, 5), List(9), F64),
    spec(Random(10, 6), Chains, F64),
    spec(Random(11, 7), List(11), F32),
    spec(Random(12, 8), Links, F64),
    spec(Random(13, 9), Chains, F64),
    spec(Random(14, 10), List(14), F64),
    spec(Random(15, 12), Chains, F64),
    spec(Random(16, 16), List(16), F64),
    spec(Random(17, 30), Chains, F64),
];

const fn spec(source: Source, division: Division, float: FloatType) -> Spec {
    Spec { source, division, float }
}

impl Spec {
    /// The file that describes the robot, if one does, from the folder of this crate.
    fn file(&self) -> Option<PathBuf> {
        match self.source {
            Golden(name) => Some(format!("golden/{name}.urdf").into()),
            Described(name) => Some(format!("../robots/{name}.urdf").into()),
            Random(..) => None,
        }
    }

    /// What [`Builder::compile`] calls the text in `OUT_DIR`, without the extension.
    #[must_use]
    pub fn module(&self) -> String {
        match self.source {
            Golden(name) => format!("golden_{name}"),
            Described(name) => name.into(),
            Random(seed, links) => format!("tree{seed}_{links}"),
        }
    }

    /// The robot.
    ///
    /// # Panics
    ///
    /// If its description cannot be read.
    #[must_use]
    pub fn model(&self) -> Model {
        let file = match (self.file(), self.source) {
            (Some(file), _) => Path::new(env!("CARGO_MANIFEST_DIR")).join(file),
            (None, Random(seed, links)) => return tree(seed, links),
            (None, _) => unreachable!("only random robots have no file"),
        };
        let name = file.display().to_string();
        let text = std::fs::read_to_string(&file).unwrap_or_else(|error| panic!("{name}: {error}"));
        let options = ReadOptions { mimic: Mimic::Independent, ..ReadOptions::default() };
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
        let builder = Builder::new().float(self.float).modules(match self.division {
            Chains => ModuleChoice::Chains,
            Links => ModuleChoice::Links,
            List(_) => {
                let name = |i: usize| model.links()[i].name.clone();
                let tree = self.modules(&model);
                let lists = tree.modules().iter().map(|module| module.links.clone().map(name));
                ModuleChoice::List(lists.map(Iterator::collect).collect())
            }
        });
        let builder = match self.file() {
            Some(file) => builder.urdf(file).mimic(Mimic::Independent),
            None => builder.model(model),
        };
        match self.source {
            // Under the name that its description gives it.
            Described(_) => builder,
            _ => builder.type_name(modyn_codegen::names::type_name(&self.module())),
        }
    }
}
