/* The paper's scheme in C: scenes on standard input, results on standard output.
 *
 * Velocity Verlet with drag and lift at the velocity of the step before, plate and ground on the
 * line between two steps, the bat looked for at the steps, Appendix B.
 *
 *     cc -O2 -o paper_verlet paper_verlet.c -lm && ./paper_verlet [--dt 0.05]
 */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct { double x, y, z; } vec;
typedef struct { vec r, v, a; } state;

static const char *scene; /* the line that is being solved */
static double dt = 0.05, drag, lift, gravity, reach, floor_z, limit;

static vec add(vec a, double k, vec b) { return (vec){a.x + k * b.x, a.y + k * b.y, a.z + k * b.z}; }
static double dot(vec a, vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static vec between(vec a, vec b, double share) { return add(a, share, add(b, -1, a)); }

/* A number of a scene: block and key, and which one of an array. Every line writes all keys out. */
static double num(const char *block, const char *key, int i) {
    char quoted[64];
    const char *p = scene;
    if (block) {
        snprintf(quoted, sizeof quoted, "\"%s\": {", block);
        if (!(p = strstr(p, quoted))) return 0; /* air: null */
    }
    snprintf(quoted, sizeof quoted, "\"%s\":", key);
    if (!(p = strstr(p, quoted))) return 0;
    for (p += strlen(quoted); *p == ' ' || *p == '['; p++) {}
    for (; i > 0; i--) p = strchr(p, ',') + 1;
    return strtod(p, NULL);
}
static vec triple(const char *block, const char *key) {
    return (vec){num(block, key, 0), num(block, key, 1), num(block, key, 2)};
}
static int is(const char *kind) {
    char quoted[32];
    snprintf(quoted, sizeof quoted, "\"kind\": \"%s\"", kind);
    return strstr(scene, quoted) != NULL;
}

static vec heading(vec v) {
    double h = hypot(v.x, v.y);
    return h > 0 ? (vec){v.x / h, v.y / h, 0} : (vec){1, 0, 0};
}
/* of a ball with velocity v that was launched toward `to` with backspin */
static vec acceleration(vec v, vec to) {
    double speed = sqrt(dot(v, v));
    vec across = {-v.z * to.x, -v.z * to.y, v.x * to.x + v.y * to.y};
    vec a = add(add((vec){0, 0, 0}, -drag * speed, v), lift * speed, across);
    a.z -= gravity;
    return a;
}
static state step(state s, vec to, vec push) {
    vec half = add(s.v, 0.5 * dt, add(s.a, 1, push)), a = acceleration(s.v, to);
    return (state){add(s.r, dt, half), add(half, 0.5 * dt, add(a, 1, push)), a};
}

static void print(const char *name, vec a) {
    printf("\"%s\": [%.17g, %.17g, %.17g]", name, a.x, a.y, a.z);
}
/* Fly to the ground; prints the landing. Time since the scene began, and since the bat was met. */
static int land(vec r, vec v, double time, double since) {
    vec to = heading(v);
    state now = {r, v, acceleration(v, to)}, old = now;
    int k = 0, last = (int)ceil(limit / dt);
    while (now.r.z > floor_z || k == 0) {
        if (k++ == last) return 0;
        old = now;
        now = step(old, to, (vec){0, 0, 0});
    }
    double drop = old.r.z - now.r.z, share = drop > 0 ? (old.r.z - floor_z) / drop : 0;
    double t = (k - 1 + share) * dt;
    r = between(old.r, now.r, share);
    r.z = floor_z;
    printf(", \"landing\": {\"time\": %.17g, \"hang_time\": %.17g, \"distance\": %.17g, ",
           time + t, since + t, hypot(r.x, r.y));
    print("position", r), printf(", "), print("velocity", between(old.v, now.v, share)), printf("}");
    return 1;
}

/* Prints contact and impact of a ball at r; returns whether ball and bat approach. */
static int collide(vec r, vec *v, double height, double time) {
    double m = num("ball", "mass", 0), M = num("bat", "mass", 0), e = num("ball", "restitution", 0);
    double L = num("bat", "length", 0), rb = num("bat", "radius", 0);
    double tilt = num("swing", "tilt", 0), d = hypot(r.x, r.z - height), lever = L / 2 - r.y;
    double w = num("swing", "angular_speed", 0) * lever;
    vec n = {r.x / d, 0, (r.z - height) / d}, vb = {w * cos(tilt), 0, w * sin(tilt)};
    double vn = dot(add(*v, -1, vb), n);
    printf(", \"contact\": {"), print("position", r), printf(", "), print("normal", n), printf(", ");
    print("bat_velocity", vb), printf(", \"normal_speed\": %.17g", vn);
    if (time >= 0) printf(", \"time\": %.17g", time);
    printf("}");
    if (vn >= 0) return 0;
    double ratio = m * lever * lever / (M * (L * L / 3 + rb * rb / 4)); /* m / M_eff */
    double et = e * (1 + ratio) + ratio, mu = m * M / (m + M), J = -mu * (1 + et) * vn;
    *v = add(*v, J / m, n);
    printf(", \"impact\": {\"restitution\": %.17g, \"impulse\": %.17g, \"energy_change\": %.17g, ",
           et, J, -0.5 * mu * (1 - et * et) * vn * vn);
    print("velocity", *v), printf("}");
    return 1;
}

/* Steps from k, where the bat is going to be met at the next step (Appendix B). */
static const char *bat(state s, int k, double inside_y, double height) {
    vec v = s.v, push;
    double a = v.x * v.x + v.z * v.z, b = s.r.x * v.x + (s.r.z - height) * v.z;
    double c = s.r.x * s.r.x + (s.r.z - height) * (s.r.z - height) - reach * reach;
    double ahead = c / (-b + sqrt(b * b - a * c)), time = k * dt + ahead;
    vec touching = add(s.r, ahead, v);
    if (fabs(inside_y) >= num("bat", "length", 0) / 2) {
        printf(", \"contact\": {\"time\": %.17g, ", time), print("position", touching), printf("}");
        return "beyond_bat";
    }
    if (!collide(touching, &v, height, time)) return "separating";
    push = add((vec){0, 0, 0}, 1 / (2 * dt), add(v, -1, s.v));
    s.a = acceleration(s.v, heading(s.v));
    for (int i = 0; i < 2; i++) s = step(s, heading(s.v), push);
    return land(s.r, s.v, (k + 2) * dt, 2 * dt - ahead) ? "batted" : "airborne";
}

static const char *pitch(void) {
    vec r = triple("pitch", "release");
    vec c = add((vec){0, num("pitch", "aim", 0), num("pitch", "aim", 1)}, -1, r);
    vec v = add((vec){0, 0, 0}, num("pitch", "speed", 0) / sqrt(dot(c, c)), c), to = heading(v);
    state start = {r, v, acceleration(v, to)}, now = start, old = now;
    int k = 0, last = (int)ceil(limit / dt);
    double ground = is("pitch") ? 0 : floor_z;
    while (now.r.x > 0 && now.r.z > ground) {
        if (k++ == last) return "airborne";
        old = now;
        now = step(old, to, (vec){0, 0, 0});
    }
    double share = old.r.x / (old.r.x - now.r.x);
    vec plate = between(old.r, now.r, share);
    if (now.r.x > 0 || plate.z <= ground) return "grounded";
    plate.x = 0;
    printf(", \"plate\": {\"time\": %.17g, ", (k - 1 + share) * dt), print("position", plate);
    printf(", "), print("velocity", between(old.v, now.v, share)), printf("}");
    if (is("pitch")) return "crossed";
    double height = plate.z + num("swing", "height_offset", 0), d = 0;
    double closest = hypot(start.r.x, start.r.z - height);
    for (now = start, k = 0; now.r.x > -reach && now.r.z > ground && k <= last; k++) {
        old = now;
        now = step(old, to, (vec){0, 0, 0});
        d = hypot(now.r.x, now.r.z - height);
        closest = fmin(closest, d);
        if (d < reach) return bat(old, k, now.r.y, height);
    }
    printf(", \"contact\": {\"margin\": %.17g}", reach - closest);
    return "missed";
}

static const char *solve(void) {
    vec v = triple("incoming", "velocity"), r = triple("incoming", "position");
    if (is("flight"))
        return land(triple("launch", "position"), triple("launch", "velocity"), 0, 0) ? "landed"
                                                                                     : "airborne";
    if (!is("impact")) return pitch();
    if (fabs(r.y) >= num("bat", "length", 0) / 2) return "beyond_bat";
    return collide(r, &v, num("incoming", "bat_height", 0), -1) ? "struck" : "separating";
}

int main(int count, char **words) {
    static char line[1 << 16];
    if (count > 2 && !strcmp(words[1], "--dt")) dt = strtod(words[2], NULL);
    while (fgets(line, sizeof line, stdin)) {
        scene = line;
        const char *id = strstr(line, "\"id\": ") + 6, *end = id + 1;
        while (*end != '"') end += *end == '\\' ? 2 : 1; /* as it is written, quotes and all */
        printf("{\"id\": %.*s", (int)(end + 1 - id), id);
        if (!strstr(line, "\"reading\": {}")) {
            printf(", \"error\": \"only the default reading is understood\"}\n");
            continue;
        }
        double radius = num("ball", "radius", 0);
        double k = num("air", "density", 0) * acos(-1) * radius * radius / (2 * num("ball", "mass", 0));
        drag = k * num("air", "drag_coefficient", 0), lift = k * num("air", "lift_coefficient", 0);
        gravity = num(NULL, "gravity", 0), limit = num(NULL, "time_limit", 0);
        reach = radius + num("bat", "radius", 0), floor_z = num("ground", "height", 0);
        printf(", \"outcome\": \"%s\"}\n", solve());
        fflush(stdout);
    }
    return 0;
}
