// Vectors are arrays of three numbers, quaternions of four (x, y, z, w), matrices of sixteen, column by column.

const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const norm = (a) => Math.hypot(a[0], a[1], a[2]);
const unit = (a) => { const length = norm(a); return length > 0 ? scale(a, 1 / length) : [0, 0, 1]; };
const mix = (a, b, t) => a.map((x, i) => x + (b[i] - x) * t);

const identity = () => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

function multiply(a, b) {
  const c = new Array(16);
  for (let j = 0; j < 4; j++) {
    for (let i = 0; i < 4; i++) {
      c[4 * j + i] = a[i] * b[4 * j] + a[4 + i] * b[4 * j + 1] + a[8 + i] * b[4 * j + 2] + a[12 + i] * b[4 * j + 3];
    }
  }
  return c;
}

const transformPoint = (m, p) => [0, 1, 2].map((i) => m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i]);
const rotate = (m, d) => [0, 1, 2].map((i) => m[i] * d[0] + m[4 + i] * d[1] + m[8 + i] * d[2]);
const origin = (m) => [m[12], m[13], m[14]];

const translation = (p) => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, p[0], p[1], p[2], 1];
const scaling = (s) => [s[0], 0, 0, 0, 0, s[1], 0, 0, 0, 0, s[2], 0, 0, 0, 0, 1];

// The matrix of a pose: nine numbers of the rotation, row by row, then the three of the translation.
const fromPose = (p) => [p[0], p[3], p[6], 0, p[1], p[4], p[7], 0, p[2], p[5], p[8], 0, p[9], p[10], p[11], 1];

// The matrix with these axes (of any length) and this origin.
const fromAxes = (x, y, z, p) => [...x, 0, ...y, 0, ...z, 0, ...p, 1];

// Axes of which z has this direction.
function axesAlong(direction) {
  const z = unit(direction);
  const x = unit(cross(Math.abs(z[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0], z));
  return [x, cross(z, x), z];
}

function rotationAbout(axis, angle) {
  const [x, y, z] = axis, c = Math.cos(angle), s = Math.sin(angle), d = 1 - c;
  return [
    c + x * x * d, x * y * d + z * s, x * z * d - y * s, 0,
    x * y * d - z * s, c + y * y * d, y * z * d + x * s, 0,
    x * z * d + y * s, y * z * d - x * s, c + z * z * d, 0,
    0, 0, 0, 1,
  ];
}

function fromQuaternion(q) {
  const length = Math.hypot(...q) || 1, [x, y, z, w] = q.map((e) => e / length);
  return [
    1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y), 0,
    2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x), 0,
    2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y), 0,
    0, 0, 0, 1,
  ];
}

// The quaternion of a matrix without scale.
function toQuaternion(m) {
  const trace = m[0] + m[5] + m[10];
  let q;
  if (trace > 0) q = [m[6] - m[9], m[8] - m[2], m[1] - m[4], 1 + trace];
  else if (m[0] > m[5] && m[0] > m[10]) q = [1 + m[0] - m[5] - m[10], m[1] + m[4], m[8] + m[2], m[6] - m[9]];
  else if (m[5] > m[10]) q = [m[1] + m[4], 1 + m[5] - m[0] - m[10], m[6] + m[9], m[8] - m[2]];
  else q = [m[8] + m[2], m[6] + m[9], 1 + m[10] - m[0] - m[5], m[1] - m[4]];
  const length = Math.hypot(...q);
  return q.map((e) => e / length);
}

// A quaternion from three angles: the rotation about their vector.
function quaternionOfVector(v) {
  const angle = norm(v), s = angle > 1e-9 ? Math.sin(angle / 2) / angle : 0.5;
  return [v[0] * s, v[1] * s, v[2] * s, Math.cos(angle / 2)];
}

function vectorOfQuaternion(q) {
  const [x, y, z, w] = q[3] < 0 ? q.map((e) => -e) : q;
  const sine = Math.hypot(x, y, z);
  return scale([x, y, z], sine > 1e-9 ? 2 * Math.atan2(sine, w) / sine : 2);
}

// The eigenvectors and eigenvalues of a symmetric matrix xx, xy, xz, yy, yz, zz, by Jacobi's rotations.
function principalAxes([xx, xy, xz, yy, yz, zz]) {
  const a = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
  const v = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  for (let sweep = 0; sweep < 20; sweep++) {
    for (const [p, q] of [[0, 1], [0, 2], [1, 2]]) {
      if (Math.abs(a[p][q]) < 1e-15 * (Math.abs(a[p][p]) + Math.abs(a[q][q]))) continue;
      const angle = 0.5 * Math.atan2(2 * a[p][q], a[q][q] - a[p][p]), c = Math.cos(angle), s = Math.sin(angle);
      for (const m of [a, v]) {
        for (const row of m) [row[p], row[q]] = [c * row[p] - s * row[q], s * row[p] + c * row[q]];
      }
      for (let k = 0; k < 3; k++) [a[p][k], a[q][k]] = [c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]];
    }
  }
  const axes = [0, 1, 2].map((k) => [v[0][k], v[1][k], v[2][k]]);
  if (dot(cross(axes[0], axes[1]), axes[2]) < 0) axes[2] = scale(axes[2], -1);
  return { axes, moments: [a[0][0], a[1][1], a[2][2]] };
}

function perspective(fieldOfView, aspect, near, far) {
  const f = 1 / Math.tan(fieldOfView / 2);
  return [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, 2 * far * near / (near - far), 0];
}

const orthographic = (half, depth) =>
  [1 / half, 0, 0, 0, 0, 1 / half, 0, 0, 0, 0, -1 / depth, 0, 0, 0, 0, 1];

function lookAt(eye, target, up) {
  const z = unit(subtract(eye, target)), x = unit(cross(up, z)), y = cross(z, x);
  return [x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, -dot(x, eye), -dot(y, eye), -dot(z, eye), 1];
}
