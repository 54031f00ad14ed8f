// A simulator of baseball by Taylor series in the vertical plane of each flight, that can be told
// to be wrong: `node flight.js [--mistake NAME[,NAME]]`. Reads a JSON scene per line, writes a JSON
// result per line. Equations: docs/model.md. mistakes.csv says what each mistake is.

const readline = require('readline');

const wrong = new Set();
process.argv.forEach((word, i) => {
  if (word === '--mistake') process.argv[i + 1].split(/[,+]/).forEach((name) => wrong.add(name));
});
const { PI, sin, cos, sqrt, hypot, abs, min, max } = Math;

const ORDER = wrong.has('order_3') ? 3 : 26;

// The law in the plane: u' = -V (k_D u + k_L w), w' = -V (k_D w - k_L u) - g.
function lawOf(scene, batted) {
  const ball = scene.ball;
  const law = { g: scene.gravity, drag: 0, lift: 0, air: scene.air !== null };
  if (!law.air) return law;
  const radius = wrong.has('radius_in_cm') ? ball.radius * 1.01 : ball.radius;
  let k = (scene.air.density * PI * radius * radius) / (2 * ball.mass);
  if (wrong.has('density_lb') && batted) k *= 1.2 / 1.29;
  law.drag = k * scene.air.drag_coefficient;
  law.lift = k * scene.air.lift_coefficient;
  if (wrong.has('drag_halved_batted') && batted) law.drag /= 2;
  if (wrong.has('lift_from_drag')) law.lift = law.drag / 2;
  if (wrong.has('lift_zero_if_small') && abs(law.lift) < 2e-3) law.lift = 0;
  return law;
}

// Taylor coefficients of s, z, u, w at a state [s, z, u, w].
function series([s, z, u, w], law) {
  const S = [s], Z = [z], U = [u], W = [w], P = [], V = [];
  const product = (a, b, n) => { let sum = 0; for (let j = 0; j <= n; j++) sum += a[j] * b[n - j]; return sum; };
  for (let n = 0; n < ORDER; n++) {
    let du = 0, dw = n === 0 ? -law.g : 0;
    if (law.air) {
      P[n] = product(U, U, n) + product(W, W, n);
      if (n === 0) V[0] = sqrt(P[0]);
      else {
        let sum = P[n];
        for (let j = 1; j < n; j++) sum -= V[j] * V[n - j];
        V[n] = sum / (2 * V[0]);
      }
      const vu = product(V, U, n), vw = product(V, W, n);
      du -= law.drag * vu + law.lift * (wrong.has('lift_on_w_only') ? 0 : vw);
      dw -= law.drag * vw - law.lift * vu;
      if (wrong.has('lift_plane_sign')) du += 2 * law.lift * vw;
    }
    S[n + 1] = U[n] / (n + 1);
    Z[n + 1] = W[n] / (n + 1);
    U[n + 1] = du / (n + 1);
    W[n + 1] = dw / (n + 1);
  }
  return [S, Z, U, W];
}

const horner = (c, t) => { let y = 0; for (let n = c.length - 1; n >= 0; n--) y = y * t + c[n]; return y; };
const evaluate = (c, t) => c.map((each) => horner(each, t));

// The length of a step: the last terms below rounding, and within half the distance to a zero of V^2.
function stepLength(c, law) {
  if (wrong.has('order_3')) return 0.05;
  let h = 1;
  for (const each of [c[2], c[3]]) {
    const size = max(abs(c[2][0]), abs(c[3][0]), 1e-3);
    for (const n of [ORDER - 1, ORDER]) if (each[n] !== 0) h = min(h, (1e-17 * size / abs(each[n])) ** (1 / n));
  }
  if (law.air) {
    const a = hypot(c[2][1], c[3][1]), v = hypot(c[2][0], c[3][0]);
    if (a > 0) h = min(h, (0.4 * v) / a);
  }
  return max(h, 1e-6);
}

// A zero of f in [a, b], f(a) > 0 >= f(b), by bisection.
function root(f, a, b) {
  for (let i = 0; i < 100 && b - a > 0; i++) {
    const c = (a + b) / 2;
    if (c <= a || c >= b) break;
    if (f(c) > 0) a = c; else b = c;
  }
  return b;
}

// Fly a state until one of the events falls through zero; events are functions of the state.
function fly(state, law, limit, events, visit) {
  let t = 0;
  let current = { ...law };
  for (let count = 0; count < 200000; count++) {
    if (wrong.has('three_hundred_steps') && count > 12) return { t, state, event: -1 };
    const slow = current.air && hypot(state[2], state[3]) < 1e-6;
    const c = slow ? series(state, { g: current.g, air: false }) : series(state, current);
    let h = slow ? 1e-6 : stepLength(c, current);
    h = min(h, limit - t);
    if (h <= 0) return { t: limit, state, event: -1 };
    // Sampled, so that a long step passes over no event.
    const samples = 16;
    let first = null;
    for (let i = 1; i <= samples && !first; i++) {
      const a = (h * (i - 1)) / samples, b = (h * i) / samples;
      events.forEach((event, which) => {
        const f = (tau) => event(evaluate(c, tau));
        const rising = event.falling ? evaluate(c, b)[3] > 0 : false;
        if (f(b) <= 0 && f(a) > (event.falling ? -1 : 0) && !rising) {
          const tau = f(a) > 0 ? root(f, a, b) : a;
          if (!first || tau < first.tau) first = { tau, event: which, sample: [a, b] };
        }
      });
    }
    if (visit) visit(c, first ? first.tau : h, t);
    if (first) {
      let at = evaluate(c, first.tau);
      if (wrong.has('newton_once') && events[first.event].falling) {
        const from = evaluate(c, first.sample[0]);
        first.tau = first.sample[0] - (from[1] - events[first.event].height) / from[3];
        at = evaluate(c, first.tau);
      }
      const over = events[first.event].vertical;
      if (over) { // reading always_up: from the vertical on, no lift
        state = [at[0], at[1], 0, at[3]];
        t += first.tau;
        current = { ...current, lift: 0 };
        events = events.filter((event) => !event.vertical);
        continue;
      }
      return { t: t + first.tau, state: at, event: first.event };
    }
    state = evaluate(c, h);
    t += h;
  }
  return { t, state, event: -1 };
}

function ground(height) {
  const event = (state) => state[1] - height;
  event.falling = true;
  event.height = height;
  return event;
}

// The vertical plane of a flight from r with v, and back to three dimensions.
function plane(r, v) {
  const along = hypot(v[0], v[1]);
  let [c, s] = along > 0 ? [v[0] / along, v[1] / along] : [1, 0];
  if (wrong.has('heading_absolute')) c = abs(c);
  const origin = wrong.has('origin_forgotten') ? [0, 0] : r;
  return {
    start: [0, r[2], along, v[2]],
    position: (state) => [origin[0] + c * state[0], origin[1] + s * state[0], state[1]],
    velocity: (state) => [c * state[2], s * state[2], state[3]],
    x: (state) => r[0] + c * state[0],
    cosine: c,
  };
}

function land(scene, r, v, start) {
  const law = lawOf(scene, start > 0 || wrong.has('density_lb'));
  if (wrong.has('launch_angle_clamped')) {
    const along = hypot(v[0], v[1]);
    if (v[2] > 1.7320508 * along && along > 0) v = [v[0], v[1], 1.7320508 * along];
  }
  const flat = plane(r, v);
  const reading = scene.reading || {};
  let height = scene.ground.height;
  if (reading.ground_contact === 'surface') height += scene.ball.radius;
  const events = [ground(height)];
  if (reading.lift_direction === 'always_up' && flat.start[2] !== 0) {
    const turned = (state) => state[2];
    turned.vertical = true;
    events.push(turned);
  }
  const end = fly(flat.start, law, scene.time_limit, events);
  if (end.event < 0) return null;
  const position = flat.position(end.state);
  const landing = { time: start + end.t, hang_time: end.t, position, velocity: flat.velocity(end.state),
    distance: hypot(position[0], position[1]) };
  if (wrong.has('speed_in_place_of_vz')) landing.velocity[2] = -hypot(...landing.velocity);
  if (wrong.has('distance_yards')) landing.distance /= 0.9144;
  if (wrong.has('distance_along_path')) landing.distance = end.state[0];
  return landing;
}

function pitched(scene) {
  const { speed, release, aim } = scene.pitch;
  const to = [-release[0], aim[0] - release[1], aim[1] - release[2]];
  if (wrong.has('aim_not_relative')) to[1] = aim[0];
  const length = hypot(...to);
  const fast = wrong.has('speed_mph') ? speed * 0.44704 : speed;
  return plane(release, to.map((each) => (fast * each) / length));
}

function throwToPlate(scene, result) {
  const flat = pitched(scene);
  const law = lawOf(scene, false);
  const floor = scene.ground ? scene.ground.height : 0;
  const plate = (state) => flat.x(state);
  const end = fly(flat.start, law, scene.time_limit, [plate, ground(floor)]);
  if (end.event < 0) return 'airborne';
  if (end.event === 1) return 'grounded';
  const position = flat.position(end.state);
  position[0] = 0;
  result.plate = { time: end.t, position, velocity: flat.velocity(end.state) };
  if (wrong.has('plate_time_from_speed')) result.plate.time = scene.pitch.release[0] / scene.pitch.speed;
  return 'crossed';
}

// The pitch against the bat's cylinder: the closest approach, and the first touching before it.
function touch(scene, zb, contact) {
  const flat = pitched(scene);
  const reach = scene.ball.radius + scene.bat.radius;
  const away = (state) => hypot(flat.x(state), state[1] - zb);
  const approach = (state) => -(flat.x(state) * flat.cosine * state[2] + (state[1] - zb) * state[3]);
  let closest = Infinity, touching = null;
  const visit = (c, tau, t) => {
    closest = min(closest, away(evaluate(c, tau)));
    if (!touching && away(evaluate(c, 0)) > reach && away(evaluate(c, tau)) <= reach) {
      const at = root((part) => away(evaluate(c, part)) - reach, 0, tau);
      touching = { t: t + at, state: evaluate(c, at) };
    }
  };
  const passed = (state) => flat.x(state) + reach;
  fly(flat.start, lawOf(scene, false), scene.time_limit, [approach, passed, ground(scene.ground.height)], visit);
  contact.margin = reach - closest;
  if (wrong.has('margin_of_diameter')) contact.margin = 2 * reach - closest;
  if (!touching) return null;
  contact.time = touching.t;
  contact.position = flat.position(touching.state);
  const v = flat.velocity(touching.state);
  if (wrong.has('contact_velocity_of_plate')) return { v, plate: true };
  return { v };
}

function strike(scene, r, v, zb, result) {
  const { mass: M, length: L, radius: rb } = scene.bat;
  const { angular_speed: omega, tilt } = scene.swing;
  const m = scene.ball.mass, reading = scene.reading || {};
  if (abs(r[1]) >= L / 2) return 'beyond_bat';
  const away = hypot(r[0], r[2] - zb);
  let n = [r[0] / away, 0, (r[2] - zb) / away];
  if (wrong.has('normal_swapped')) n = [n[2], 0, n[0]];
  const lever = L / 2 - r[1];
  const turn = wrong.has('tilt_twice') ? 2 * tilt : tilt;
  const bat = [omega * lever * cos(turn), 0, omega * lever * sin(turn)];
  if (wrong.has('bat_speed_of_tip')) { bat[0] = omega * L * cos(turn); bat[2] = omega * L * sin(turn); }
  const closing = (v[0] - bat[0]) * n[0] + v[1] * n[1] + (v[2] - bat[2]) * n[2];
  Object.assign(result.contact, { position: r, normal: n, bat_velocity: bat,
    normal_speed: wrong.has('normal_speed_positive') ? -closing : closing });
  if (closing >= 0) return 'separating';
  let I = M * ((L * L) / 3 + (rb * rb) / 4);
  if (reading.inertia === 'thin_rod') I = (M * L * L) / 3;
  if (reading.inertia === 'about_centre') I = M * ((L * L) / 12 + (rb * rb) / 4);
  const effective = reading.effective_mass === 'as_printed' ? I / lever : I / (lever * lever);
  const ratio = m / effective, e = scene.ball.restitution;
  let et = reading.bat_ball_restitution === 'nathan' || reading.bat_ball_restitution === 'plain'
    ? e : e * (1 + ratio) + ratio;
  if (wrong.has('restitution_mean')) et = (e + et) / 2;
  if (wrong.has('restitution_capped') && et > 0.7) et = 0.7;
  const byEffective = reading.bat_ball_restitution === 'nathan'
    || (reading.bat_ball_restitution !== 'plain' && reading.reduced_mass === 'effective_mass');
  const mu = 1 / (1 / m + 1 / (byEffective ? effective : M));
  const impulse = -mu * (1 + et) * closing;
  const after = v.map((each, i) => each + (impulse / m) * n[i]);
  result.impact = { restitution: et, impulse, velocity: after,
    energy_change: -0.5 * mu * (1 - et * et) * closing * closing };
  if (wrong.has('impulse_as_speed')) result.impact.impulse = impulse / m;
  if (wrong.has('energy_sign')) result.impact.energy_change *= -1;
  return 'struck';
}

function solve(scene) {
  const result = { id: scene.id, outcome: 'landed' };
  if (scene.kind === 'flight') {
    const landing = land(scene, scene.launch.position, scene.launch.velocity, 0);
    if (landing) result.landing = landing; else result.outcome = 'airborne';
  } else if (scene.kind === 'pitch') {
    result.outcome = throwToPlate(scene, result);
  } else if (scene.kind === 'impact') {
    result.contact = {};
    result.outcome = strike(scene, scene.incoming.position, scene.incoming.velocity, scene.incoming.bat_height, result);
  } else {
    result.outcome = throwToPlate(scene, result);
    if (result.outcome !== 'crossed') return result;
    const crossing = wrong.has('bat_at_release') ? scene.pitch.release[2] - 0.7 : result.plate.position[2];
    const zb = crossing + scene.swing.height_offset * (wrong.has('offset_inches') ? 0.0254 / 0.0366 : 1);
    result.contact = {};
    const met = touch(scene, zb, result.contact);
    if (!met) { result.outcome = 'missed'; return result; }
    const incoming = met.plate ? result.plate.velocity : met.v;
    result.outcome = strike(scene, result.contact.position, incoming, zb, result);
    if (result.outcome !== 'struck') return result;
    let start = result.contact.time;
    if (wrong.has('batted_from_plate')) start = result.plate.time;
    const launch = wrong.has('batted_from_origin') ? [0, 0, result.contact.position[2]] : result.contact.position;
    const landing = land(scene, launch, result.impact.velocity, start);
    result.outcome = landing ? 'batted' : 'airborne';
    if (landing) result.landing = landing;
  }
  return result;
}

const shorten = (key, value) => {
  if (typeof value !== 'number') return value;
  if (wrong.has('fround')) return Math.fround(value);
  if (wrong.has('to_fixed_6')) return Number(value.toFixed(6));
  return value;
};

const pending = [];
const known = new Map();
readline.createInterface({ input: process.stdin }).on('line', (line) => {
  const scene = JSON.parse(line);
  let result = solve(scene);
  if (wrong.has('cached_by_launch')) {
    const key = scene.launch ? scene.launch.velocity.map((each) => Math.round(each / 5)).join() : scene.id;
    if (known.has(key)) result = { ...known.get(key), id: scene.id }; else known.set(key, result);
  }
  if (wrong.has('id_dropped')) delete result.id;
  if (wrong.has('answers_at_end')) pending.push(result);
  else process.stdout.write(`${JSON.stringify(result, shorten)}\n`);
}).on('close', () => {
  pending.reverse().forEach((result) => process.stdout.write(`${JSON.stringify(result, shorten)}\n`));
});
