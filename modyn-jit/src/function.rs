//! The code of a function.

use modyn_codegen::Function;
use modyn_codegen::plan::{LinkProgram, Shape};

use crate::code_size::CodeSize;
use crate::looped::LoopedCode;
use crate::machine::Code;

/// The code of a function.
pub(crate) struct CompiledFunction {
    /// The function; `None` for a fused function.
    pub function: Option<Function>,
    pub name: &'static str,
    pub arguments: Vec<(&'static str, Shape)>,
    /// Whether the robot's run-time parameters are a further argument.
    pub has_parameters: bool,
    pub result: Shape,
    pub kernels: CompiledKernels,
    pub size: CodeSize,
}

/// The compiled programs of a function.
pub(crate) enum CompiledKernels {
    /// One program.
    One(Kernel),
    /// A program with loops: its code for one state, and that for a state in each lane.
    Looped { single: Box<LoopedCode>, batch: Option<Box<LoopedCode>> },
    /// The program of each link, and the code of the programs.
    ByLink(Vec<LinkProgram>, Vec<Kernel>),
    /// The poses of some links and bodies, and the pose of a link from its body's pose. Each link
    /// has the index of its own pose, or the index of its body's pose and the row of its placement.
    Poses { bodies: Kernel, placed: Kernel, links: Vec<LinkProgram> },
}

/// The code of a program.
pub(crate) struct Kernel {
    /// The code for one state.
    pub single: Code,
    /// The code for a state in each lane.
    pub batch: Option<Code>,
}

impl Kernel {
    /// Returns the code for this number of states at a time: one, or the lanes of a vector.
    pub fn code(&self, lanes: usize) -> &Code {
        match &self.batch {
            Some(batch) if lanes > 1 => batch,
            _ => &self.single,
        }
    }
}
