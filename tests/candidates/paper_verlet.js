// The paper's scheme in JavaScript (Node): scenes on standard input, results on standard output.
//
// Velocity Verlet with drag and lift at the velocity of the step before, plate and ground on the
// line between two steps, the bat looked for at the steps, Appendix B.
// Usage: node paper_verlet.js [--dt 0.05]

const at = process.argv.indexOf("--dt");
const dt = at < 0 ? 0.05 : Number(process.argv[at + 1]);

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const add = (a, b, factor = 1) => a.map((p, i) => p + factor * b[i]);
const between = (a, b, share) => a.map((p, i) => p + share * (b[i] - p));

function heading(v) {
  const h = Math.hypot(v[0], v[1]);
  return h > 0 ? [v[0] / h, v[1] / h] : [1, 0];
}

// The acceleration of a ball with velocity v that was launched toward `to` with backspin.
function acceleration(scene, v, to) {
  const { ball, air, gravity } = scene;
  const k = air ? (air.density * Math.PI * ball.radius ** 2) / (2 * ball.mass) : 0;
  const [drag, lift] = air ? [k * air.drag_coefficient, k * air.lift_coefficient] : [0, 0];
  const speed = Math.sqrt(dot(v, v));
  const across = [-v[2] * to[0], -v[2] * to[1], v[0] * to[0] + v[1] * to[1]];
  const a = v.map((p, i) => speed * (-drag * p + lift * across[i]));
  return [a[0], a[1], a[2] - gravity];
}

function step(scene, { r, v, a }, to, push = [0, 0, 0]) {
  const half = add(v, add(a, push), 0.5 * dt);
  const next = acceleration(scene, v, to ?? heading(v));
  return { r: add(r, half, dt), v: add(half, add(next, push), 0.5 * dt), a: next };
}

// Step until ended(r): the number of steps, and the states before and after the last.
function fly(scene, r, v, ended) {
  const to = heading(v);
  let now = { r, v, a: acceleration(scene, v, to) };
  for (let k = 1; k <= Math.ceil(scene.time_limit / dt); k++) {
    const before = now;
    now = step(scene, before, to);
    if (ended(now.r)) return { k, before, after: now };
  }
  return null;
}

function land(scene, r, v, time, since) {
  const floor = scene.ground.height;
  const flight = fly(scene, r, v, (p) => p[2] <= floor);
  if (!flight) return null;
  const { k, before, after } = flight;
  const drop = before.r[2] - after.r[2];
  const share = drop > 0 ? (before.r[2] - floor) / drop : 0;
  const t = (k - 1 + share) * dt;
  const [x, y] = between(before.r, after.r, share);
  return {
    time: time + t,
    hang_time: since + t,
    position: [x, y, floor],
    velocity: between(before.v, after.v, share),
    distance: Math.hypot(x, y),
  };
}

function pitched(scene) {
  const { release, speed, aim } = scene.pitch;
  const c = add([0, ...aim], release, -1);
  const v = c.map((p) => (speed / Math.sqrt(dot(c, c))) * p);
  const floor = scene.ground?.height ?? 0;
  const flight = fly(scene, release, v, (p) => p[0] <= 0 || p[2] <= floor);
  if (!flight) return { v, outcome: "airborne" };
  const { k, before, after } = flight;
  const share = before.r[0] / (before.r[0] - after.r[0]);
  const [, y, z] = between(before.r, after.r, share);
  if (after.r[0] > 0 || z <= floor) return { v, outcome: "grounded" };
  const velocity = between(before.v, after.v, share);
  const plate = { time: (k - 1 + share) * dt, position: [0, y, z], velocity };
  return { v, outcome: "crossed", plate };
}

// The contact of a ball at r, and the impact there if ball and bat approach.
function collide({ ball, bat, swing }, r, v, height) {
  const d = Math.hypot(r[0], r[2] - height);
  const normal = [r[0] / d, 0, (r[2] - height) / d];
  const lever = bat.length / 2 - r[1];
  const speed = swing.angular_speed * lever;
  const vb = [speed * Math.cos(swing.tilt), 0, speed * Math.sin(swing.tilt)];
  const vn = dot(add(v, vb, -1), normal);
  const contact = { position: r, normal, bat_velocity: vb, normal_speed: vn };
  if (vn >= 0) return { contact };
  const inertia = bat.mass * (bat.length ** 2 / 3 + bat.radius ** 2 / 4);
  const ratio = (ball.mass * lever ** 2) / inertia; // m / M_eff
  const e = ball.restitution * (1 + ratio) + ratio;
  const mu = (ball.mass * bat.mass) / (ball.mass + bat.mass);
  const impulse = -mu * (1 + e) * vn;
  const velocity = add(v, normal, impulse / ball.mass);
  const energy_change = -0.5 * mu * (1 - e * e) * vn * vn;
  return { contact, impact: { restitution: e, impulse, velocity, energy_change } };
}

function atBat(scene) {
  const { v: start, outcome, plate } = pitched(scene);
  if (outcome !== "crossed") return { outcome };
  const height = plate.position[2] + scene.swing.height_offset;
  const reach = scene.ball.radius + scene.bat.radius;
  const distance = (p) => Math.hypot(p[0], p[2] - height);
  let closest = distance(scene.pitch.release);
  const flight = fly(scene, scene.pitch.release, start, (p) => {
    closest = Math.min(closest, distance(p));
    return distance(p) < reach || p[0] <= -reach || p[2] <= scene.ground.height;
  });
  if (!flight || distance(flight.after.r) >= reach)
    return { outcome: "missed", plate, contact: { margin: reach - closest } };
  const { k, before, after } = flight;
  const { r, v } = before;
  // |d + v Δt'| = reach, d from the axis to the ball (Appendix B)
  const a = v[0] ** 2 + v[2] ** 2;
  const b = r[0] * v[0] + (r[2] - height) * v[2];
  const c = r[0] ** 2 + (r[2] - height) ** 2 - reach ** 2;
  const ahead = c / (-b + Math.sqrt(b * b - a * c));
  const touching = add(r, v, ahead);
  const time = (k - 1) * dt + ahead;
  if (Math.abs(after.r[1]) >= scene.bat.length / 2)
    return { outcome: "beyond_bat", plate, contact: { time, position: touching } };
  const { contact, impact } = collide(scene, touching, v, height);
  contact.time = time;
  if (!impact) return { outcome: "separating", plate, contact };
  const push = add(impact.velocity, v, -1).map((p) => p / (2 * dt));
  let now = { r, v, a: acceleration(scene, v, heading(v)) };
  for (let i = 0; i < 2; i++) now = step(scene, now, null, push);
  const landing = land(scene, now.r, now.v, (k + 1) * dt, 2 * dt - ahead);
  return { outcome: landing ? "batted" : "airborne", plate, contact, impact, landing };
}

function solve(scene) {
  if (Object.keys(scene.reading).length) return { error: "only the default reading" };
  if (scene.kind === "at-bat") return atBat(scene);
  if (scene.kind === "pitch") {
    const { outcome, plate } = pitched(scene);
    return { outcome, plate };
  }
  if (scene.kind === "flight") {
    const landing = land(scene, scene.launch.position, scene.launch.velocity, 0, 0);
    return { outcome: landing ? "landed" : "airborne", landing };
  }
  const { position, velocity, bat_height } = scene.incoming;
  if (Math.abs(position[1]) >= scene.bat.length / 2) return { outcome: "beyond_bat" };
  const { contact, impact } = collide(scene, position, velocity, bat_height);
  return { outcome: impact ? "struck" : "separating", contact, impact };
}

const lines = require("node:readline").createInterface({ input: process.stdin });
lines.on("line", (line) => {
  const scene = JSON.parse(line);
  console.log(JSON.stringify({ id: scene.id, ...solve(scene) }));
});
