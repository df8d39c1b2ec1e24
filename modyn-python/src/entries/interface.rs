//! The part of XLA's C interface of custom calls that modyn uses, as `xla/ffi/api/c_api.h` declares
//! it (version 0.1 and later, which add fields after these alone).

use std::ffi::{c_char, c_void};

/// The type of a struct that extends another one.
#[repr(C)]
pub struct Extension {
    pub size: usize,
    pub kind: u32,
    pub next: *mut Extension,
}

/// [`Extension::kind`] of [`MetadataExtension`].
pub const METADATA: u32 = 1;

#[repr(C)]
pub struct ApiVersion {
    pub size: usize,
    pub extension: *mut Extension,
    pub major: i32,
    pub minor: i32,
}

/// What XLA asks a handler for when it is registered.
#[repr(C)]
pub struct Metadata {
    pub size: usize,
    pub api_version: ApiVersion,
    pub traits: u32,
}

/// The entry of [`Metadata::traits`] of a handler that starts the same kernels in every call, so that
/// a CUDA graph can repeat them.
pub const COMMAND_BUFFER: u32 = 1;

#[repr(C)]
pub struct MetadataExtension {
    pub base: Extension,
    pub metadata: *mut Metadata,
}

/// An error, which XLA owns.
pub type Error = *mut c_void;

/// The functions of XLA.
#[repr(C)]
pub struct Api {
    pub size: usize,
    pub extension: *mut Extension,
    pub version: ApiVersion,
    pub internal: *const c_void,
    pub error_create: extern "C" fn(*mut ErrorCreate) -> Error,
    pub error_message: *const c_void,
    pub error_destroy: extern "C" fn(*mut ErrorDestroy),
    pub handler_register: *const c_void,
    pub stream: Option<extern "C" fn(*mut StreamGet) -> Error>,
    pub type_register: *const c_void,
    pub context_get: *const c_void,
    pub state_set: *const c_void,
    pub state_get: *const c_void,
    pub allocate: *const c_void,
    pub free: *const c_void,
    pub schedule: Option<extern "C" fn(*mut Schedule) -> Error>,
    pub threads: Option<extern "C" fn(*mut NumThreads) -> Error>,
}

#[repr(C)]
pub struct ErrorCreate {
    pub size: usize,
    pub extension: *mut Extension,
    pub message: *const c_char,
    pub code: u32,
}

/// [`ErrorCreate::code`] of an invalid argument.
pub const INVALID_ARGUMENT: u32 = 3;

#[repr(C)]
pub struct ErrorDestroy {
    pub size: usize,
    pub extension: *mut Extension,
    pub error: Error,
}

/// A question for the stream of a call.
#[repr(C)]
pub struct StreamGet {
    pub size: usize,
    pub extension: *mut Extension,
    pub context: *mut c_void,
    pub stream: *mut c_void,
}

/// A task for XLA's threads.
#[repr(C)]
pub struct Schedule {
    pub size: usize,
    pub extension: *mut Extension,
    pub context: *mut c_void,
    pub task: unsafe extern "C" fn(*mut c_void),
    pub data: *mut c_void,
}

#[repr(C)]
pub struct NumThreads {
    pub size: usize,
    pub extension: *mut Extension,
    pub context: *mut c_void,
    pub threads: *mut i64,
}

/// [`Buffer::dtype`] of `f32`.
pub const F32: u32 = 11;
/// [`Buffer::dtype`] of `f64`.
pub const F64: u32 = 12;

/// An array.
#[repr(C)]
pub struct Buffer {
    pub size: usize,
    pub extension: *mut Extension,
    pub dtype: u32,
    pub data: *mut c_void,
    pub rank: i64,
    pub dims: *mut i64,
}

#[repr(C)]
pub struct Buffers {
    pub size: usize,
    pub extension: *mut Extension,
    pub count: i64,
    pub types: *mut u32,
    pub buffers: *mut *mut Buffer,
}

#[repr(C)]
pub struct Bytes {
    pub data: *const u8,
    pub length: usize,
}

#[repr(C)]
pub struct ScalarAttribute {
    pub dtype: u32,
    pub value: *const c_void,
}

/// [`ScalarAttribute::dtype`] of `i64`.
pub const I64: u32 = 5;

#[repr(C)]
pub struct Attributes {
    pub size: usize,
    pub extension: *mut Extension,
    pub count: i64,
    pub types: *mut u32,
    pub names: *mut *mut Bytes,
    pub attributes: *mut *mut c_void,
}

/// The entry of [`Attributes::types`] of a scalar.
pub const SCALAR: u32 = 3;

/// A call of a handler.
#[repr(C)]
pub struct CallFrame {
    pub size: usize,
    pub extension: *mut Extension,
    pub api: *const Api,
    pub context: *mut c_void,
    pub stage: u32,
    pub arguments: Buffers,
    pub results: Buffers,
    pub attributes: Attributes,
}
