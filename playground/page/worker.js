// Runs modyn beside the page. The first message has the compiled module; each other one is a request with an identifier.
"use strict";

let instance = null;
const decoder = new TextDecoder(), encoder = new TextEncoder();

function read(place, length) {
  return decoder.decode(new Uint8Array(instance.exports.memory.buffer, place, length));
}

function answer(request, bytes = new Uint8Array()) {
  const { exports } = instance, json = encoder.encode(JSON.stringify(request));
  const at = exports.input(json.length + bytes.length);
  // Making room for the request may have moved the memory.
  const memory = new Uint8Array(exports.memory.buffer);
  memory.set(json, at);
  memory.set(bytes, at + json.length);
  const length = exports.run(json.length);
  return JSON.parse(read(exports.answer(), length));
}

// What stopped modyn: a panic has a message, a full stack or memory has none.
function reason(error) {
  try {
    const { exports } = instance, length = exports.fault_length();
    if (length) return read(exports.fault(), length);
  } catch { /* The memory cannot be read. */ }
  return error instanceof RangeError || /memory|stack/i.test(error.message) ? "the robot needs more memory or a deeper stack than the page has" : error.message;
}

onmessage = async ({ data: { id, module, request, bytes } }) => {
  if (module) {
    instance = await WebAssembly.instantiate(module, {});
    return;
  }
  try {
    postMessage({ id, answer: answer(request, bytes) });
  } catch (error) {
    postMessage({ id, fault: reason(error) });
  }
};
