//! Rigid-body dynamics of a robot for many states at a time on a graphics processor.
//!
//! [`Gpu`] is a graphics processor of the machine, or Mesa's software processor where there is
//! none. [`GpuRobot`] holds the kernels of a robot, which modyn compiles to WGSL at run time: no
//! build step is needed. Arrays stay on the processor ([`GpuArray`]) until they are read.
//! [`Rollout`] computes motions over many time steps in one kernel.
//!
//! The robot is a description, a model, or a type that `modyn!` generated with the option
//! `embed_model`:
//! `GpuRobot::new(&gpu, &Builder::new().robot::<Arm7>().functions([Function::ForwardDynamics]))`.
//!
//! Scalar `j` of state `i` of `n` states is number `j n + i` of an array. Numbers are in single
//! precision. [`Gpu::upload_states`] and [`GpuArray::read_states`] have an array for each state
//! instead.
//!
//! ```
//! use modyn_codegen::{Builder, Function};
//! use modyn_gpu::{Gpu, GpuRobot};
//!
//! let text = r#"<robot name="pendulum"><link name="world"/>
//!     <joint name="pivot" type="continuous"><parent link="world"/><child link="bob"/><axis xyz="0 1 0"/></joint>
//!     <link name="bob"><inertial><origin xyz="0 0 -0.5"/><mass value="2"/>
//!     <inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"#;
//! let gpu = Gpu::new()?;
//! let builder = Builder::new().urdf_text(text, "pendulum.urdf").functions([Function::ForwardDynamics]);
//! let robot = GpuRobot::new(&gpu, &builder)?;
//! // Three states: hanging, at 0.1 rad, at a right angle.
//! let q = gpu.upload(&[0.0, 0.1, core::f32::consts::FRAC_PI_2], 3)?;
//! let rest = gpu.upload(&[0.0; 3], 3)?;
//! let qdd = robot.run("forward_dynamics", &[&q, &rest, &rest])?.read()?;
//! // m g l / (I + m l^2) = 2 * 9.81 * 0.5 / (0.1 + 2 * 0.25)
//! assert!(qdd[0].abs() < 1e-5 && (qdd[2] + 16.35).abs() < 1e-4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod array;
mod error;
mod kernel;
mod processor;
mod robot;
mod rollout;

pub use array::GpuArray;
pub use error::GpuError;
pub use processor::Gpu;
pub use robot::{GpuRobot, GpuSource};
pub use rollout::{Rollout, RolloutArguments, RolloutResults};
