// Files that the page makes: archives of pictures (ZIP without compression), and scenes (GLB, binary glTF 2).

const CRC = Uint32Array.from({ length: 256 }, (_, n) => {
  for (let k = 0; k < 8; k++) n = n & 1 ? 0xedb88320 ^ n >>> 1 : n >>> 1;
  return n;
});

function checksum(bytes) {
  let crc = 0xffffffff;
  for (const byte of bytes) crc = CRC[(crc ^ byte) & 255] ^ crc >>> 8;
  return (crc ^ 0xffffffff) >>> 0;
}

// The numbers in little endian: pairs of a width in bytes and a number.
function packed(...fields) {
  const bytes = new Uint8Array(fields.reduce((sum, [width]) => sum + width, 0)), view = new DataView(bytes.buffer);
  let at = 0;
  for (const [width, number] of fields) {
    if (width === 2) view.setUint16(at, number, true); else view.setUint32(at, number, true);
    at += width;
  }
  return bytes;
}

// An archive of files, { name, bytes }, as a Blob.
function zip(files) {
  const parts = [], directory = [];
  let at = 0;
  const push = (list, bytes) => { list.push(bytes); return bytes.length; };
  for (const { name, bytes } of files) {
    const label = new TextEncoder().encode(name);
    const shared = [[2, 20], [2, 0x800], [2, 0], [2, 0], [2, 0x21], [4, checksum(bytes)], [4, bytes.length], [4, bytes.length], [2, label.length]];
    push(directory, packed([4, 0x02014b50], [2, 20], ...shared, [2, 0], [2, 0], [2, 0], [2, 0], [4, 0], [4, at]));
    push(directory, label);
    at += push(parts, packed([4, 0x04034b50], ...shared, [2, 0])) + push(parts, label) + push(parts, bytes);
  }
  const size = directory.reduce((sum, bytes) => sum + bytes.length, 0), count = files.length;
  const end = packed([4, 0x06054b50], [2, 0], [2, 0], [2, count], [2, count], [4, size], [4, at], [2, 0]);
  return new Blob([...parts, ...directory, end], { type: "application/zip" });
}

// A binary glTF of instances: { name, bodies: [{ name, geometry, pose at rest }], times, poses: for each time those of the
// bodies }. Without times it is a still scene.
function glb(title, instances) {
  const chunks = [], gltf = {
    asset: { version: "2.0", generator: "modyn" }, scene: 0, scenes: [{ name: title, nodes: [0] }],
    // glTF has y upwards.
    nodes: [{ name: title, rotation: [-Math.SQRT1_2, 0, 0, Math.SQRT1_2], children: [] }],
    meshes: [], accessors: [], bufferViews: [], buffers: [],
    materials: [{ pbrMetallicRoughness: { baseColorFactor: [1, 1, 1, 1], metallicFactor: 0.1, roughnessFactor: 0.55 }, doubleSided: true }],
  };
  let length = 0;
  const accessor = (data, type, componentType, more = {}) => {
    gltf.bufferViews.push({ buffer: 0, byteOffset: length, byteLength: data.byteLength });
    const bytes = new Uint8Array(Math.ceil(data.byteLength / 4) * 4);
    bytes.set(new Uint8Array(data.buffer, data.byteOffset, data.byteLength));
    chunks.push(bytes);
    length += bytes.length;
    const parts = { SCALAR: 1, VEC3: 3, VEC4: 4 }[type];
    gltf.accessors.push({ bufferView: gltf.bufferViews.length - 1, componentType, type, count: data.length / parts, ...more });
    return gltf.accessors.length - 1;
  };
  const range = (data) => {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    data.forEach((x, i) => { low[i % 3] = Math.min(low[i % 3], x); high[i % 3] = Math.max(high[i % 3], x); });
    return { min: low, max: high };
  };
  const FLOAT = 5126, UINT = 5125, BYTE = 5121, meshes = new Map();
  const mesh = (geometry) => {
    if (!meshes.has(geometry)) {
      // Colours are linear in glTF.
      const colors = Uint8Array.from(geometry.colors, (x, i) => i % 4 === 3 ? x : Math.round(255 * (x / 255) ** 2.2));
      gltf.meshes.push({ primitives: [{ material: 0, indices: accessor(geometry.indices, "SCALAR", UINT), attributes: {
        POSITION: accessor(geometry.positions, "VEC3", FLOAT, range(geometry.positions)),
        NORMAL: accessor(geometry.normals, "VEC3", FLOAT),
        COLOR_0: accessor(colors, "VEC4", BYTE, { normalized: true }),
      } }] });
      meshes.set(geometry, gltf.meshes.length - 1);
    }
    return meshes.get(geometry);
  };
  for (const { name, bodies, times, poses } of instances) {
    const animation = { name, samplers: [], channels: [] };
    const input = times.length > 1
      ? accessor(Float32Array.from(times, (time) => time - times[0]), "SCALAR", FLOAT, { min: [0], max: [times[times.length - 1] - times[0]] }) : null;
    bodies.forEach((body, i) => {
      const node = gltf.nodes.length, place = poses[0][i];
      gltf.nodes.push({ name: `${name}/${body.name}`, mesh: mesh(body.geometry), translation: origin(place), rotation: toQuaternion(place) });
      gltf.nodes[0].children.push(node);
      if (input === null) return;
      const quaternions = poses.map((list) => toQuaternion(list[i]));
      quaternions.forEach((q, k) => {
        if (k > 0 && q.reduce((sum, x, j) => sum + x * quaternions[k - 1][j], 0) < 0) quaternions[k] = q.map((x) => -x);
      });
      for (const [path, numbers, type] of [["translation", poses.map((list) => origin(list[i])), "VEC3"], ["rotation", quaternions, "VEC4"]]) {
        animation.channels.push({ sampler: animation.samplers.length, target: { node, path } });
        animation.samplers.push({ input, output: accessor(new Float32Array(numbers.flat()), type, FLOAT) });
      }
    });
    if (animation.channels.length) (gltf.animations ||= []).push(animation);
  }
  gltf.buffers.push({ byteLength: length });
  let text = JSON.stringify(gltf);
  text += " ".repeat((4 - new TextEncoder().encode(text).length % 4) % 4);
  const json = new TextEncoder().encode(text);
  return new Blob([
    packed([4, 0x46546c67], [4, 2], [4, 28 + json.length + length], [4, json.length], [4, 0x4e4f534a]), json,
    packed([4, length], [4, 0x004e4942]), ...chunks,
  ], { type: "model/gltf-binary" });
}

function download(blob, name) {
  const link = document.createElement("a"), address = URL.createObjectURL(blob);
  Object.assign(link, { download: name });
  link["href"] = address;
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 60000);
}
