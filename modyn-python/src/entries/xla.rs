//! The handler by which XLA calls functions of arrays: one for all, whose attribute `function` is
//! the key of the code.
//!
//! Unsafe code: XLA's structs and arrays are read by their addresses. It is sound because XLA keeps
//! them as long as a call takes, and their layout follows XLA's header (`interface.rs`). Arguments
//! are not written meanwhile, and results overlap nothing. A task for XLA's threads owns a
//! reference to its job, so it can run at any time; the work of the job, which borrows from the
//! call, is only touched with a chunk that is not done, and the call ends when all chunks are done.
#![allow(unsafe_code)]

use std::ffi::{CString, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::null_mut;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use pyo3::prelude::*;

use super::cuda;
use super::interface::{
    Api, Attributes, Buffer, Buffers, COMMAND_BUFFER, CallFrame, Error, ErrorCreate, ErrorDestroy,
    F32, F64, I64, INVALID_ARGUMENT, METADATA, MetadataExtension, NumThreads, SCALAR,
    ScalarAttribute, Schedule, StreamGet,
};
use crate::codes::{AnyCode, ArrayCode, Broadcast, Numbers, Results, find, leading, missing};
use crate::number::Number;
use crate::pool::Pool;

/// Returns the address of XLA's handler of all functions of arrays.
#[pyfunction]
pub fn xla_handler() -> usize {
    (handler as unsafe extern "C" fn(*mut CallFrame) -> Error) as *const () as usize
}

/// Returns the address of XLA's handler of all functions of arrays on CUDA; for tests the address of
/// a handler that XLA calls on the host.
#[pyfunction]
#[pyo3(signature = (on_host=false))]
pub fn xla_cuda_handler(on_host: bool) -> usize {
    type Handler = unsafe extern "C" fn(*mut CallFrame) -> Error;
    let handler: Handler = if on_host { cuda_handler::<true> } else { cuda_handler::<false> };
    handler as *const () as usize
}

unsafe extern "C" fn handler(frame: *mut CallFrame) -> Error {
    // SAFETY: see the header.
    unsafe { answered(frame, 0, |frame, api| call(frame, api)) }
}

unsafe extern "C" fn cuda_handler<const ON_HOST: bool>(frame: *mut CallFrame) -> Error {
    // SAFETY: see the header.
    unsafe { answered(frame, COMMAND_BUFFER, |frame, api| call_on_cuda::<ON_HOST>(frame, api)) }
}

/// Answers XLA's question for metadata, else calls a function.
unsafe fn answered(
    frame: *mut CallFrame,
    traits: u32,
    call: impl Fn(&CallFrame, &Api) -> Result<(), String>,
) -> Error {
    // SAFETY: see the header.
    let frame = unsafe { &*frame };
    // SAFETY: see the header.
    if unsafe { answers_metadata(frame, traits) } {
        return null_mut();
    }
    // SAFETY: see the header. Only a question for metadata has no functions of XLA.
    let Some(api) = (unsafe { frame.api.as_ref() }) else { return null_mut() };
    let called = catch_unwind(AssertUnwindSafe(|| call(frame, api)));
    let text = match called {
        Ok(Ok(())) => return null_mut(),
        Ok(Err(message)) => message,
        Err(_) => "modyn: a call failed, which is a fault of modyn".into(),
    };
    let message = CString::new(text).unwrap_or_default();
    let mut arguments = ErrorCreate {
        size: size_of::<ErrorCreate>(),
        extension: null_mut(),
        message: message.as_ptr(),
        code: INVALID_ARGUMENT,
    };
    (api.error_create)(&raw mut arguments)
}

/// Answers XLA's question for the version of its interface, if this call is the question.
unsafe fn answers_metadata(frame: &CallFrame, traits: u32) -> bool {
    // SAFETY: see the header.
    unsafe {
        match frame.extension.as_ref() {
            Some(extension) if extension.kind == METADATA => {}
            _ => return false,
        }
        let metadata = &mut *(*frame.extension.cast::<MetadataExtension>()).metadata;
        metadata.api_version.major = 0;
        // The fields that are used have been the same since version 0.1. jaxlib before 0.8 asks
        // without functions, and takes version 0.1 alone.
        metadata.api_version.minor = frame.api.as_ref().map_or(1, |api| api.version.minor);
        metadata.traits = traits;
        true
    }
}

unsafe fn call(frame: &CallFrame, api: &Api) -> Result<(), String> {
    // SAFETY: see the header.
    unsafe {
        let key = key(&frame.attributes).ok_or("modyn: a call has no attribute `function`")?;
        let threads = XlaThreads { api, context: frame.context };
        match &*find(key).ok_or_else(|| missing(key))? {
            AnyCode::F64(code) => typed(frame, code, F64, &threads),
            AnyCode::F32(code) => typed(frame, code, F32, &threads),
        }
    }
}

/// Starts a kernel on the stream of the call; without a stream if XLA runs the call on the host.
unsafe fn call_on_cuda<const ON_HOST: bool>(frame: &CallFrame, api: &Api) -> Result<(), String> {
    // SAFETY: see the header.
    let [arguments, results] = unsafe { [arrays(&frame.arguments), arrays(&frame.results)] };
    // SAFETY: see the header.
    let key =
        unsafe { key(&frame.attributes) }.ok_or("modyn: a call has no attribute `function`")?;
    let kernel = cuda::kernel(key).ok_or_else(|| missing(key))?;
    let dtype = if kernel.is_double() { F64 } else { F32 };
    let fits = arguments.len() == kernel.inputs().len()
        && results.len() == kernel.outputs()
        && arguments.iter().chain(&results).all(|array| array.dtype == dtype);
    if !fits {
        return Err("modyn: a call has arrays of another function".into());
    }
    let pairs = arguments.iter().zip(kernel.inputs());
    // SAFETY: see the header.
    let all_axes = pairs.map(|(array, own_axes)| leading(unsafe { dims(array) }, own_axes));
    let axes = all_axes.collect::<Result<Vec<&[usize]>, String>>()?;
    let mut question = StreamGet {
        size: size_of::<StreamGet>(),
        extension: null_mut(),
        context: frame.context,
        stream: null_mut(),
    };
    let threads = XlaThreads { api, context: frame.context };
    let has_stream = api.stream.is_some_and(|get| threads.succeeded(get(&raw mut question)));
    if !has_stream && !ON_HOST {
        return Err("modyn: XLA has no stream for a call on CUDA".into());
    }
    let strides: Vec<usize> =
        kernel.inputs().iter().map(|own_axes| own_axes.iter().product()).collect();
    let addresses = arguments.iter().chain(&results).map(|array| array.data.addr());
    // SAFETY: see the header.
    unsafe { kernel.launch(question.stream.addr(), &axes, &strides, addresses.collect()) }
}

/// Returns the attribute `function`.
unsafe fn key(attributes: &Attributes) -> Option<i64> {
    // SAFETY: see the header.
    unsafe {
        (0..usize::try_from(attributes.count).ok()?).find_map(|i| {
            let name = &**attributes.names.add(i);
            let is_key = std::slice::from_raw_parts(name.data, name.length) == b"function"
                && *attributes.types.add(i) == SCALAR;
            let attribute = *attributes.attributes.add(i);
            let scalar = is_key.then(|| &*attribute.cast::<ScalarAttribute>());
            scalar.filter(|scalar| scalar.dtype == I64).map(|scalar| *scalar.value.cast::<i64>())
        })
    }
}

/// Calls the code, whose arrays must have this type of numbers.
unsafe fn typed<S: Number>(
    frame: &CallFrame,
    code: &ArrayCode<S>,
    dtype: u32,
    threads: &XlaThreads<'_>,
) -> Result<(), String> {
    // SAFETY: see the header.
    let [arguments, results] = unsafe { [arrays(&frame.arguments), arrays(&frame.results)] };
    if arguments.iter().chain(&results).any(|array| array.dtype != dtype) {
        return Err(format!("modyn: the arrays of a call must have numbers of {}", S::DTYPE));
    }
    let axes = arguments.iter().zip(code.shapes().inputs());
    // SAFETY: see the header.
    let leading_axes = axes.map(|(array, own_axes)| leading(unsafe { dims(array) }, own_axes));
    let axes = leading_axes.collect::<Result<Vec<&[usize]>, String>>()?;
    let combined = Broadcast::new(&axes, code.shapes().lengths()[0]);
    let broadcast = combined.map_err(|fault| fault.to_string())?;
    // SAFETY: see the header.
    let given: Vec<Numbers<'_, S>> = unsafe {
        arguments.iter().map(|array| {
            let count = dims(array).iter().product();
            match count {
                0 => (&[][..]).into(),
                _ => std::slice::from_raw_parts(array.data.cast::<S>(), count).into(),
            }
        })
    }
    .collect();
    // SAFETY: see the header.
    let outputs: Vec<Results<'_, S>> = unsafe {
        results.iter().map(|array| {
            let count = dims(array).iter().product();
            match count {
                0 => (&mut [][..]).into(),
                _ => std::slice::from_raw_parts_mut(array.data.cast::<S>(), count).into(),
            }
        })
    }
    .collect();
    code.compute(&broadcast, &given, &outputs, threads)
}

unsafe fn arrays<'a>(buffers: &Buffers) -> Vec<&'a Buffer> {
    // SAFETY: see the header.
    unsafe {
        let count = usize::try_from(buffers.count).unwrap_or_default();
        (0..count).map(|i| &**buffers.buffers.add(i)).collect()
    }
}

/// Returns the lengths of the axes of an array, none of which is negative.
unsafe fn dims(array: &Buffer) -> &[usize] {
    const { assert!(size_of::<usize>() == size_of::<i64>(), "XLA has processors of 64 bits alone") };
    match usize::try_from(array.rank) {
        Ok(rank @ 1..) => {
            // SAFETY: see the header; the numbers have the same size.
            unsafe { std::slice::from_raw_parts(array.dims.cast::<usize>(), rank) }
        }
        _ => &[],
    }
}

/// The threads of XLA.
struct XlaThreads<'a> {
    api: &'a Api,
    context: *mut c_void,
}

// SAFETY: XLA's functions can be called from any thread.
unsafe impl Sync for XlaThreads<'_> {}

impl XlaThreads<'_> {
    /// Returns whether a call of XLA succeeded.
    fn succeeded(&self, error: Error) -> bool {
        if !error.is_null() {
            let size = size_of::<ErrorDestroy>();
            let extension = null_mut();
            let mut destroy = ErrorDestroy { size, extension, error };
            (self.api.error_destroy)(&raw mut destroy);
        }
        error.is_null()
    }

    /// Lets one of the threads run a job some time; returns false if there is none.
    fn schedule(&self, job: &Arc<Job>) -> bool {
        let Some(schedule) = self.api.schedule else { return false };
        let data = Arc::into_raw(job.clone()).cast_mut().cast::<c_void>();
        let mut arguments = Schedule {
            size: size_of::<Schedule>(),
            extension: null_mut(),
            context: self.context,
            task,
            data,
        };
        let is_scheduled = self.succeeded(schedule(&raw mut arguments));
        if !is_scheduled {
            // SAFETY: nobody else has this reference.
            drop(unsafe { Arc::from_raw(data.cast_const().cast::<Job>()) });
        }
        is_scheduled
    }
}

impl Pool for XlaThreads<'_> {
    fn threads(&self) -> usize {
        let Some(threads) = self.api.threads else { return 1 };
        let mut count = 1_i64;
        let mut arguments = NumThreads {
            size: size_of::<NumThreads>(),
            extension: null_mut(),
            context: self.context,
            threads: &raw mut count,
        };
        let is_known = self.succeeded(threads(&raw mut arguments));
        // The thread that calls is none of these.
        if is_known { usize::try_from(count).unwrap_or_default().max(1) } else { 1 }
    }

    fn must_end(&self) -> bool {
        // XLA waits for its calls.
        false
    }

    fn share(&self, chunks: usize, run: &(dyn Fn(usize) + Sync)) {
        // SAFETY: only the lifetime changes; see the header.
        let run: *const (dyn Fn(usize) + Sync) =
            unsafe { std::mem::transmute::<&(dyn Fn(usize) + Sync), _>(run) };
        let next = AtomicUsize::new(0);
        let done = AtomicUsize::new(0);
        let job = Arc::new(Job { next, done, chunks, run });
        // This thread takes part, so the work is done even if no other thread is free.
        for _ in 1..chunks {
            if !self.schedule(&job) {
                break;
            }
        }
        job.work();
        while job.done.load(Ordering::Acquire) < chunks {
            std::thread::yield_now();
        }
    }
}

/// The work of a call, in chunks that threads take one after the other.
struct Job {
    next: AtomicUsize,
    done: AtomicUsize,
    chunks: usize,
    run: *const (dyn Fn(usize) + Sync),
}

// SAFETY: the work can be run by any thread, and is touched as the header says.
unsafe impl Send for Job {}
// SAFETY: as above.
unsafe impl Sync for Job {}

impl Job {
    /// Runs chunks until none is left.
    fn work(&self) {
        loop {
            let chunk = self.next.fetch_add(1, Ordering::Relaxed);
            if chunk >= self.chunks {
                return;
            }
            // SAFETY: this chunk is not done, so the call still waits; see the header.
            unsafe { (*self.run)(chunk) };
            self.done.fetch_add(1, Ordering::Release);
        }
    }
}

unsafe extern "C" fn task(data: *mut c_void) {
    // SAFETY: `schedule` gave this reference away.
    let job = unsafe { Arc::from_raw(data.cast_const().cast::<Job>()) };
    job.work();
}
