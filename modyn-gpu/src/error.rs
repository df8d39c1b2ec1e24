//! Errors of computations on a graphics processor.

use std::error::Error;
use std::fmt;

use modyn_codegen::diagnostics::Diagnostics;

/// The reason why a computation on a graphics processor failed.
#[derive(Debug)]
#[non_exhaustive]
pub enum GpuError {
    /// No processor was found.
    NoAdapter(String),
    /// The processor could not be opened.
    NoDevice(String),
    /// The description or the options are wrong.
    Description(Diagnostics),
    /// The robot has no such kernel.
    NoKernel {
        /// The name that was asked for.
        name: String,
        /// The kernels of the robot.
        kernels: Vec<String>,
    },
    /// An array has another size than the kernel needs.
    Shape {
        /// The kernel.
        kernel: String,
        /// The argument.
        argument: String,
        /// The scalars of a state that the kernel needs.
        scalars: usize,
        /// The scalars of a state that the array has.
        given: usize,
    },
    /// A kernel was given the wrong number of arguments.
    Arguments {
        /// The kernel.
        kernel: String,
        /// The names of its arguments.
        expected: Vec<String>,
        /// The number of arrays that were given.
        given: usize,
    },
    /// An array was uploaded to another [`Gpu`](crate::Gpu) than the kernel's.
    OtherProcessor {
        /// The kernel.
        kernel: String,
    },
    /// The controls of a rollout are no whole number of steps.
    Controls {
        /// The kernel.
        kernel: String,
        /// The controls of a step.
        controls: usize,
        /// The scalars of a state that the array has.
        given: usize,
    },
    /// Two arrays are for different numbers of states.
    States {
        /// The kernel.
        kernel: String,
        /// The states of the first array.
        expected: usize,
        /// The states of another array.
        given: usize,
    },
    /// The length is not a whole number of scalars for each state, or there are no states.
    Length {
        /// The length.
        numbers: usize,
        /// The number of states.
        states: usize,
    },
    /// The states were asked for as arrays of another length.
    Width {
        /// The scalars of a state.
        scalars: usize,
        /// The length that was asked for.
        asked: usize,
    },
    /// An array is longer than the processor allows.
    TooLarge {
        /// The bytes of the array.
        bytes: u64,
        /// The largest size of a buffer in bytes.
        limit: u64,
    },
    /// The processor has no memory left for an array.
    OutOfMemory {
        /// The bytes of the array.
        bytes: u64,
    },
    /// The processor or its driver failed.
    Device(String),
}

impl fmt::Display for GpuError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoAdapter(why) => write!(
                f,
                "no graphics processor was found: {why}; install its driver, or Mesa's software processor (Debian: \
                 mesa-vulkan-drivers)"
            ),
            Self::NoDevice(why) => write!(f, "the graphics processor cannot be opened: {why}"),
            Self::Description(diagnostics) => write!(f, "{diagnostics}"),
            Self::NoKernel { name, kernels } => {
                write!(f, "the robot has no kernel `{name}`; it has {}", kernels.join(", "))
            }
            Self::Shape { kernel, argument, scalars, given } => {
                write!(f, "`{kernel}` takes {scalars} numbers a state as `{argument}`, not {given}")
            }
            Self::Arguments { kernel, expected, given } => {
                write!(
                    f,
                    "`{kernel}` takes the arguments {}, not {given} arrays",
                    expected.join(", ")
                )
            }
            Self::OtherProcessor { kernel } => write!(
                f,
                "`{kernel}` was given an array of another processor; clones of one `Gpu` share their arrays"
            ),
            Self::Controls { kernel, controls, given } => write!(
                f,
                "`{kernel}` takes {controls} controls a step, and {given} are no whole number of steps"
            ),
            Self::States { kernel, expected, given } => {
                write!(f, "`{kernel}` was given arrays for {expected} and for {given} states")
            }
            Self::Length { numbers, states } => {
                write!(f, "{numbers} numbers are no array for {states} states")
            }
            Self::Width { scalars, asked } => {
                write!(f, "a state has {scalars} numbers, and arrays of {asked} were asked for")
            }
            Self::TooLarge { bytes, limit } => {
                write!(
                    f,
                    "an array of {bytes} bytes is too large for the processor, whose limit is {limit}"
                )
            }
            Self::OutOfMemory { bytes } => {
                write!(
                    f,
                    "the processor has no memory left for an array of {bytes} bytes; drop arrays \
                     that are not needed, or \
                     compute fewer states at a time"
                )
            }
            Self::Device(why) => write!(f, "the graphics processor failed: {why}"),
        }
    }
}

impl Error for GpuError {}

impl From<Diagnostics> for GpuError {
    fn from(diagnostics: Diagnostics) -> Self {
        Self::Description(diagnostics)
    }
}
