/* A simulator of baseball in flight, at the plate and on the bat, that can be told to be wrong.

   Reads one JSON scene per line and writes one JSON result per line. Without arguments it solves
   the equations of docs/model.md in extended precision: flights by extrapolated midpoint steps,
   events by the false-position rule within a step. `--mistake NAME[,NAME]` plants mistakes that
   authors of simulators make; mistakes.csv says what each of them is. `--list` prints their names.

   Build:  cc -O2 -o ballistics ballistics.c -lm                                              */

#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef long double real;
#define PI 3.14159265358979323846264338327950288L

/* ------------------------------------------------------------------------------ mistakes --- */

#define MISTAKES(X) \
    /* constants and parameters of the flight */ \
    X(gravity_981) X(gravity_fixed_98) X(density_1225) X(density_fixed_129) X(mass_fixed) \
    X(mass_five_ounces) X(radius_fixed) X(area_from_diameter) X(area_without_pi) \
    X(area_of_sphere) X(half_forgotten) X(drag_fixed_05) X(coefficients_swapped) X(pi_314) \
    X(lift_ignored) X(lift_sign) X(lift_twice) \
    /* directions and forms of the forces */ \
    X(drag_linear) X(drag_launch_speed) X(drag_horizontal_only) X(drag_per_component) \
    X(drag_unsigned) X(lift_vertical) X(lift_horizontal_speed) X(lift_direction_frozen) \
    X(lift_axis_minus_y) X(no_drag_descending) X(lift_only_rising) X(no_drag_slow) \
    X(density_falls) X(speed_taxicab) X(lift_steep_off) \
    /* integrators */ \
    X(euler) X(semi_implicit_euler) X(euler_fine) X(midpoint) X(heun) X(rk4_long_steps) \
    X(rk4_equal_weights) X(adams_bashforth) X(verlet_old_velocity) X(leapfrog_lagged) \
    X(rk4_position_euler) X(rk4_frozen_speed) X(taylor2_constant_acceleration) X(float32_state) \
    /* landing */ \
    X(first_below) X(last_above) X(linear_landing) X(ground_zero) X(ground_at_radius) \
    X(clock_step_late) X(velocity_stale) X(lands_descending_through_launch) X(stops_at_20s) \
    X(time_limit_ignored) \
    /* pitch and plate */ \
    X(speed_in_kmh) X(release_fixed) X(aim_height_ignored) X(aim_side_ignored) X(aim_side_sign) \
    X(plate_17_inches) X(plate_first_beyond) X(ground_ignored_pitch) X(plate_velocity_of_release) \
    X(pitch_without_lift) X(pitch_without_drag) X(pitch_speed_horizontal) \
    /* contact */ \
    X(touching_at_plate) X(touching_bat_radius_only) X(touching_diameters) X(bat_at_aim) \
    X(offset_sign) X(offset_ignored) X(touching_step_late) X(margin_sign) X(margin_straight_line) \
    X(normal_reversed) X(normal_horizontal) X(normal_from_plate) X(normal_not_unit) \
    X(normal_in_three) \
    /* bat velocity and relative velocity */ \
    X(lever_half_length) X(lever_from_other_end) X(lever_full_length) X(lever_offset_hand) \
    X(tilt_ignored) X(tilt_sign) X(tilt_degrees) X(tilt_sine_only) X(swing_fixed_34) \
    X(bat_velocity_forgotten) X(normal_speed_added) X(normal_speed_at_plate) X(normal_speed_total) \
    /* restitution and impulse */ \
    X(restitution_fixed_042) X(restitution_plain) X(restitution_minus) X(mass_ratio_inverted) \
    X(effective_mass_printed) X(inertia_centre) X(inertia_rod) X(inertia_fixed_bat) \
    X(bat_mass_fixed) X(ball_mass_fixed_impact) X(reduced_mass_ball) X(reduced_mass_effective) \
    X(reduced_mass_half) X(one_plus_forgotten) X(one_minus_restitution) X(impulse_sign) \
    X(impulse_of_ball_velocity) X(energy_without_half) X(energy_ball_only) \
    X(separating_struck) X(velocity_by_bat_mass) X(velocity_reflected_whole) X(velocity_relative) \
    X(velocity_bat_added) X(velocity_normal_only) X(readings_ignored) \
    /* units and output */ \
    X(distance_feet) X(velocity_mph) X(rounded_2) X(distance_3d) X(distance_x) \
    X(distance_from_launch) X(hang_time_total) X(time_is_hang_time) X(y_sign) X(axes_yz_swapped) \
    X(time_ms) X(landing_speed_sign) \
    /* conduct */ \
    X(state_between_scenes) X(random_noise) X(cached_by_speed) X(only_outcome) X(camel_case) \
    X(landing_for_missed) X(refuses_readings) X(nan_after_bat) X(prints_banner) X(position_short) \
    X(missed_as_batted) X(numbers_as_text) X(static_release) \
    /* spin, wind, weather, fence, friction */ \
    X(spin_in_rpm) X(spin_sign) X(spin_parameter_diameter) X(spin_frozen_direction) \
    X(spin_only_backspin) X(wind_sign) X(wind_ignored) X(wind_added_to_ball) X(wind_on_speed_only) \
    X(weather_celsius) X(weather_humidity_sign) X(weather_elevation_ignored) X(weather_percent) \
    X(fence_height_of_first) X(fence_wall_ignored) X(fence_ball_radius) X(fence_by_angle) \
    X(friction_inertia_hollow) X(friction_no_bat_rotation) X(friction_always_grips) \
    X(friction_spin_sign) X(friction_tangential_default)

enum mistake {
#define X(name) name,
    MISTAKES(X)
#undef X
    MISTAKE_COUNT
};
static const char *const mistake_names[] = {
#define X(name) #name,
    MISTAKES(X)
#undef X
};
static bool wrong[MISTAKE_COUNT];

/* ---------------------------------------------------------------------------------- JSON --- */

typedef struct Json Json;
struct Json {
    enum { J_NULL, J_BOOL, J_NUMBER, J_STRING, J_LIST, J_OBJECT } type;
    double number;
    char *text;   /* of a string */
    char *key;    /* of a member of an object */
    Json *child, *next;
};

static char pool[1 << 24];
static size_t pool_used;

static void *take(size_t n) {
    void *p = pool + pool_used;
    pool_used += (n + 15) & ~(size_t)15;
    if (pool_used > sizeof pool) exit(3);
    memset(p, 0, n);
    return p;
}

static const char *skip_space(const char *s) {
    while (isspace((unsigned char)*s)) s++;
    return s;
}

static const char *parse_text(const char *s, char **text) {
    const char *end = ++s;
    while (*end && *end != '"') end += *end == '\\' ? 2 : 1;
    *text = take((size_t)(end - s) + 1);
    memcpy(*text, s, (size_t)(end - s));
    return end + 1;
}

static const char *parse(const char *s, Json **out) {
    Json *j = *out = take(sizeof *j), **tail = &j->child;
    s = skip_space(s);
    if (*s == '"') {
        j->type = J_STRING;
        return parse_text(s, &j->text);
    }
    if (*s == '{' || *s == '[') {
        bool object = *s == '{';
        j->type = object ? J_OBJECT : J_LIST;
        s = skip_space(s + 1);
        while (*s && *s != '}' && *s != ']') {
            char *key = NULL;
            if (object) {
                s = skip_space(parse_text(s, &key));
                s++; /* the colon */
            }
            s = skip_space(parse(s, tail));
            (*tail)->key = key;
            tail = &(*tail)->next;
            if (*s == ',') s = skip_space(s + 1);
        }
        return s + 1;
    }
    if (strncmp(s, "null", 4) == 0) return s + 4;
    if (strncmp(s, "true", 4) == 0) { j->type = J_BOOL; j->number = 1; return s + 4; }
    if (strncmp(s, "false", 5) == 0) { j->type = J_BOOL; return s + 5; }
    char *end;
    j->type = J_NUMBER;
    j->number = strtod(s, &end);
    return end;
}

static const Json *member(const Json *j, const char *key) {
    if (!j || j->type != J_OBJECT) return NULL;
    for (const Json *c = j->child; c; c = c->next)
        if (strcmp(c->key, key) == 0) return c;
    return NULL;
}

static real number(const Json *j, const char *key, real otherwise) {
    const Json *c = member(j, key);
    return c && c->type == J_NUMBER ? (real)c->number : otherwise;
}

static int numbers(const Json *list, real *out, int most) {
    int n = 0;
    if (list && list->type == J_LIST)
        for (const Json *c = list->child; c && n < most; c = c->next) out[n++] = c->number;
    return n;
}

static bool text_is(const Json *j, const char *key, const char *value) {
    const Json *c = member(j, key);
    return c && c->type == J_STRING && strcmp(c->text, value) == 0;
}

/* ------------------------------------------------------------------------------- vectors --- */

static real dot(const real a[3], const real b[3]) { return a[0]*b[0] + a[1]*b[1] + a[2]*b[2]; }
static real norm(const real a[3]) { return sqrtl(dot(a, a)); }

static void cross(const real a[3], const real b[3], real c[3]) {
    real x = a[1]*b[2] - a[2]*b[1], y = a[2]*b[0] - a[0]*b[2], z = a[0]*b[1] - a[1]*b[0];
    c[0] = x; c[1] = y; c[2] = z;
}

/* ---------------------------------------------------------------------- the law of motion --- */

typedef enum { LIFT_NUMBER, LIFT_CONSTANT, LIFT_RATIONAL, LIFT_LINEAR } LiftLaw;

typedef struct {
    bool air, spinning, up_reading, wind_on_drag_only, total_spin;
    real k;            /* rho A / (2 m); the acceleration of a coefficient 1 is k V^2 */
    real drag, lift[3];
    LiftLaw lift_law;
    real gravity, radius, scale_height;
    real wind[3], spin[3], axis[3];
    bool vertical;     /* reading always_up: the ball has turned vertical, no lift any more */
    real launch_speed, lift_normal[3];
} Law;

typedef struct { real r[3], v[3], before[3]; bool has_before; } State;

static void acceleration(const Law *law, const real r[3], const real v[3], real a[3]) {
    a[0] = a[1] = 0;
    a[2] = -law->gravity;
    if (!law->air) return;
    real u[3] = {v[0] - law->wind[0], v[1] - law->wind[1], v[2] - law->wind[2]};
    if (wrong[wind_sign]) for (int i = 0; i < 3; i++) u[i] = v[i] + law->wind[i];
    if (wrong[wind_on_speed_only]) memcpy(u, v, sizeof u);
    real speed = norm(u);
    if (wrong[wind_on_speed_only]) {
        real w[3] = {v[0] - law->wind[0], v[1] - law->wind[1], v[2] - law->wind[2]};
        speed = norm(w);
    }
    if (wrong[speed_taxicab]) speed = fabsl(u[0]) + fabsl(u[1]) + fabsl(u[2]);
    real k = law->k;
    if (law->scale_height > 0) k *= expl(-r[2] / law->scale_height);
    if (wrong[density_falls]) k *= expl(-r[2] / 8500);

    /* drag: -k C_D U u */
    real drag = k * law->drag * speed;
    if (wrong[drag_linear]) drag = k * law->drag * 30;
    if (wrong[drag_launch_speed]) drag = k * law->drag * law->launch_speed;
    if (wrong[no_drag_descending] && v[2] < 0) drag = 0;
    if (wrong[no_drag_slow] && speed < 20) drag = 0;
    for (int i = 0; i < 3; i++) {
        if (wrong[drag_per_component]) a[i] -= k * law->drag * fabsl(u[i]) * u[i];
        else if (wrong[drag_unsigned]) a[i] -= k * law->drag * u[i] * u[i];
        else if (!(wrong[drag_horizontal_only] && i == 2)) a[i] -= drag * u[i];
    }

    /* lift, about the spin or about the axis that was fixed at the launch */
    const real *w = law->wind_on_drag_only ? v : u;
    real across = norm(w), c[3];
    if (law->spinning) {
        real spin[3];
        memcpy(spin, law->spin, sizeof spin);
        if (wrong[spin_only_backspin]) spin[0] = spin[2] = 0;
        cross(spin, w, c);
        real size = norm(c);
        if (size == 0 || across == 0) return;
        if (wrong[spin_frozen_direction]) cross(spin, law->lift_normal, c), size = norm(c);
        real S = law->radius * (law->total_spin ? norm(spin) : size / across) / across;
        if (wrong[spin_parameter_diameter]) S *= 2;
        real cl = law->lift[0];
        if (law->lift_law == LIFT_RATIONAL)
            cl = law->lift[0] * S / (law->lift[1] + law->lift[2] * S);
        if (law->lift_law == LIFT_LINEAR) cl = law->lift[0] * S;
        /* with the total spin the force is k R (C_L / S) c */
        real f = law->total_spin && S > 0 ? k * law->radius * cl / S : k * cl * across * across / size;
        if (wrong[spin_sign]) f = -f;
        for (int i = 0; i < 3; i++) a[i] += f * c[i];
        return;
    }
    if (law->vertical) return;
    real lift = k * law->lift[0] * across;
    if (wrong[lift_sign]) lift = -lift;
    if (wrong[lift_only_rising] && v[2] < 0) lift = 0;
    cross(law->axis, w, c);
    if (law->up_reading) {
        real forward = -law->axis[1] * v[0] + law->axis[0] * v[1];
        if (forward < 0) lift = -lift;
    }
    if (wrong[lift_steep_off] && v[2] > 0.7L * norm(v)) lift = 0;
    if (wrong[lift_vertical]) { c[0] = c[1] = 0; c[2] = across; }
    if (wrong[lift_horizontal_speed]) lift = k * law->lift[0] * hypotl(w[0], w[1]);
    if (wrong[lift_direction_frozen])
        for (int i = 0; i < 3; i++) c[i] = law->lift_normal[i] * across;
    for (int i = 0; i < 3; i++) a[i] += lift * c[i];
}

/* --------------------------------------------------------------------------- integration --- */

static void rates(const Law *law, const real y[6], real d[6]) {
    memcpy(d, y + 3, 3 * sizeof(real));
    acceleration(law, y, y + 3, d + 3);
}

/* Modified midpoint rule over h in n substeps, with Gragg's smoothing. */
static void modified_midpoint(const Law *law, const real y[6], real h, int n, real out[6]) {
    real a[6], b[6], c[6], d[6], s = h / n;
    rates(law, y, d);
    for (int i = 0; i < 6; i++) { a[i] = y[i]; b[i] = y[i] + s * d[i]; }
    for (int m = 1; m < n; m++) {
        rates(law, b, d);
        for (int i = 0; i < 6; i++) { c[i] = a[i] + 2 * s * d[i]; a[i] = b[i]; b[i] = c[i]; }
    }
    rates(law, b, d);
    for (int i = 0; i < 6; i++) out[i] = (a[i] + b[i] + s * d[i]) / 2;
}

/* One step of order 8: four midpoint rules, extrapolated in the square of the substep. */
static void extrapolated(const Law *law, real y[6], real h) {
    static const int n[4] = {2, 4, 6, 8};
    real table[4][6];
    for (int j = 0; j < 4; j++) {
        modified_midpoint(law, y, h, n[j], table[j]);
        for (int k = j - 1; k >= 0; k--) {
            real ratio = (real)n[j] / n[k], f = 1 / (ratio * ratio - 1);
            for (int i = 0; i < 6; i++) table[k][i] = table[k+1][i] + (table[k+1][i] - table[k][i]) * f;
        }
    }
    memcpy(y, table[0], sizeof table[0]);
}

/* A classical Runge-Kutta step, with what can be wrong in it. */
static void runge_kutta(const Law *law, real y[6], real h) {
    static const real part[4] = {0, 0.5L, 0.5L, 1}, weight[4] = {1, 2, 2, 1};
    real k[6] = {0}, sum[6] = {0};
    for (int j = 0; j < 4; j++) {
        real at[6];
        for (int i = 0; i < 6; i++) at[i] = y[i] + part[j] * h * k[i];
        rates(law, at, k);
        if (wrong[rk4_position_euler]) memcpy(k, y + 3, 3 * sizeof(real));
        for (int i = 0; i < 6; i++) sum[i] += (wrong[rk4_equal_weights] ? 1.5L : weight[j]) * k[i];
    }
    for (int i = 0; i < 6; i++) y[i] += h / 6 * sum[i];
}

/* The step length of the chosen method: 0.03 s, shorter where the ball nearly rests. */
static real step_length(const Law *law, const State *s) {
    if (wrong[euler] || wrong[semi_implicit_euler] || wrong[verlet_old_velocity]) return 1e-3L;
    if (wrong[euler_fine]) return 1e-4L;
    if (wrong[rk4_long_steps]) return 0.2L;
    if (wrong[taylor2_constant_acceleration]) return 0.02L;
    if (wrong[midpoint] || wrong[heun] || wrong[rk4_equal_weights] || wrong[adams_bashforth] ||
        wrong[leapfrog_lagged] || wrong[rk4_position_euler] || wrong[rk4_frozen_speed])
        return 0.01L;
    bool grid = wrong[first_below] || wrong[last_above] || wrong[linear_landing] || wrong[clock_step_late] ||
                wrong[velocity_stale] || wrong[plate_first_beyond] || wrong[touching_step_late];
    real a[3], h = grid ? 0.01L : 0.03L;
    acceleration(law, s->r, s->v, a);
    real u[3] = {s->v[0] - law->wind[0], s->v[1] - law->wind[1], s->v[2] - law->wind[2]};
    real slow = 0.05L * norm(u) / (norm(a) + 1e-30L);
    if (law->air && slow < h) h = slow < 1e-7L ? 1e-7L : slow;
    return h;
}

static State stepped(const Law *law, State s, real h) {
    real y[6], a[3], b[3];
    memcpy(y, s.r, sizeof s.r);
    memcpy(y + 3, s.v, sizeof s.v);
    acceleration(law, s.r, s.v, a);
    if (wrong[euler] || wrong[euler_fine]) {
        for (int i = 0; i < 3; i++) { y[i] += h * y[3+i]; y[3+i] += h * a[i]; }
    } else if (wrong[semi_implicit_euler]) {
        for (int i = 0; i < 3; i++) { y[3+i] += h * a[i]; y[i] += h * y[3+i]; }
    } else if (wrong[taylor2_constant_acceleration]) {
        for (int i = 0; i < 3; i++) { y[i] += h * y[3+i] + h * h / 2 * a[i]; y[3+i] += h * a[i]; }
    } else if (wrong[midpoint] || wrong[heun]) {
        bool half = wrong[midpoint];
        real at[6], d[6], first[6];
        rates(law, y, first);
        for (int i = 0; i < 6; i++) at[i] = y[i] + (half ? h / 2 : h) * first[i];
        rates(law, at, d);
        for (int i = 0; i < 6; i++) y[i] += half ? h * d[i] : h / 2 * (first[i] + d[i]);
    } else if (wrong[adams_bashforth]) {
        real step = step_length(law, &s), ratio = h / (2 * step);
        for (int i = 0; i < 3; i++) {
            real old = s.has_before ? s.before[i] : a[i];
            y[i] += h * y[3+i] + h * h / 2 * a[i];
            y[3+i] += h * (a[i] + ratio * (a[i] - old));
        }
    } else if (wrong[verlet_old_velocity]) {
        /* velocity Verlet, the force at the new position taken with the old velocity */
        for (int i = 0; i < 3; i++) y[i] += h * y[3+i] + h * h / 2 * a[i];
        acceleration(law, y, s.v, b);
        for (int i = 0; i < 3; i++) y[3+i] += h / 2 * (a[i] + b[i]);
    } else if (wrong[leapfrog_lagged]) {
        /* half a drift, a kick with the old velocity, half a drift */
        for (int i = 0; i < 3; i++) y[i] += h / 2 * y[3+i];
        acceleration(law, y, y + 3, b);
        for (int i = 0; i < 3; i++) { y[3+i] += h * b[i]; y[i] += h / 2 * y[3+i]; }
    } else if (wrong[rk4_long_steps] || wrong[rk4_equal_weights] || wrong[rk4_position_euler]) {
        runge_kutta(law, y, h);
    } else if (wrong[rk4_frozen_speed]) {
        /* drag and lift factors computed once per step from the speed at its start */
        Law frozen = *law;
        frozen.launch_speed = norm(s.v);
        bool keep = wrong[drag_launch_speed];
        wrong[drag_launch_speed] = true;
        runge_kutta(&frozen, y, h);
        wrong[drag_launch_speed] = keep;
    } else extrapolated(law, y, h);
    State after = {.has_before = true};
    memcpy(after.before, a, sizeof a);
    for (int i = 0; i < 3; i++) {
        after.r[i] = wrong[float32_state] ? (real)(float)y[i] : y[i];
        after.v[i] = wrong[float32_state] ? (real)(float)y[3+i] : y[3+i];
    }
    return after;
}

typedef real (*Gauge)(const State *, const void *);

/* The part of a step of length h after which gauge falls through 0, and the state there. */
static real locate(const Law *law, const State *from, real h, Gauge gauge, const void *of, State *at) {
    real a = 0, b = h, fa = gauge(from, of), fb;
    State end = stepped(law, *from, h);
    fb = gauge(&end, of);
    *at = end;
    if (fa <= 0) { *at = *from; return 0; }
    int side = 0;
    real c = h;
    for (int i = 0; i < 200 && b - a > 1e-19L * (1 + h); i++) {
        c = (fa - fb) != 0 ? (fa * b - fb * a) / (fa - fb) : (a + b) / 2;
        if (!(c > a && c < b) || i % 8 == 7) c = (a + b) / 2;
        *at = stepped(law, *from, c);
        real f = gauge(at, of);
        if (f == 0) return c;
        if (f > 0) { a = c; fa = f; if (side == 1) fb /= 2; side = 1; }
        else { b = c; fb = f; if (side == -1) fa /= 2; side = -1; }
    }
    *at = stepped(law, *from, b);
    return b;
}

/* ------------------------------------------------------------------------------- results --- */

typedef struct { real time, r[3], v[3]; } Instant;

typedef struct {
    const char *outcome, *code;
    bool plate, contact, margin, full_contact, impact, landing, fence, oblique, spun, fair_known;
    Instant at_plate, at_contact, at_landing, at_fence;
    real normal[3], bat_velocity[3], normal_speed, contact_margin;
    real restitution, impulse, after[3], energy, spin_after[3], friction_margin;
    const char *mode;
    real hang, distance, spin[3], clearance, fence_margin;
    int segment;
    bool fair, fence_has_margin, contact_time;
} Result;

typedef struct {
    const Json *scene, *ball, *air, *bat, *swing, *reading, *fence;
    real m, R, e, gravity, time_limit, ground;
} Scene;

static const real still[3] = {0, 0, 0};

/* Density from the weather, docs/model.md. */
static real density_of(const Json *air, const Json *reading) {
    const Json *d = member(air, "density");
    if (!d || d->type == J_NUMBER) return d ? (real)d->number : 1.29L;
    real T = number(d, "temperature", 288.15L), p = number(d, "pressure", 101325);
    real phi = number(d, "humidity", 0), h = number(d, "elevation", 0), t = T - 273.15L;
    if (wrong[weather_celsius]) t = T;
    if (wrong[weather_humidity_sign]) phi = -phi;
    if (wrong[weather_percent]) phi /= 100;
    if (wrong[weather_elevation_ignored]) h = 0;
    real ps = 611.16L * expl((18.687L - t / 234.5L) * t / (257.14L + t));
    if (!text_is(reading, "pressure", "station")) p *= expl(-1.217e-4L * h);
    return 1.2929L * (273.15L / T) * (p - 0.3783L * phi * ps) / 101325;
}

static Law law_of(const Scene *s, const real v[3], const real *spin) {
    Law law = {.gravity = s->gravity, .radius = s->R};
    if (wrong[gravity_981]) law.gravity = 9.81L;
    if (wrong[gravity_fixed_98]) law.gravity = 9.8L;
    if (!s->air || s->air->type != J_OBJECT) return law;
    law.air = true;
    real rho = density_of(s->air, s->reading), R = s->R, m = s->m;
    if (wrong[density_1225]) rho = 1.225L;
    if (wrong[density_fixed_129]) rho = 1.29L;
    if (wrong[mass_fixed]) m = 0.145L;
    if (wrong[mass_five_ounces]) m = 0.1417L; /* 5 oz */
    if (wrong[radius_fixed]) R = 0.0366L;
    real A = (wrong[pi_314] ? 3.14L : PI) * R * R;
    if (wrong[area_from_diameter]) A = PI * (2 * R) * (2 * R);
    if (wrong[area_without_pi]) A = R * R;
    if (wrong[area_of_sphere]) A = 4 * PI * R * R / 3;
    law.k = rho * A / (2 * m);
    if (wrong[half_forgotten]) law.k *= 2;
    law.scale_height = number(s->air, "density_scale_height", 0);
    law.drag = number(s->air, "drag_coefficient", 0.4L);
    if (wrong[drag_fixed_05]) law.drag = 0.5L;
    const Json *lift = member(s->air, "lift_coefficient");
    law.lift[0] = lift && lift->type == J_NUMBER ? (real)lift->number : 0.2L;
    if (lift && lift->type == J_OBJECT) {
        if (text_is(lift, "law", "rational")) {
            law.lift_law = LIFT_RATIONAL;
            law.lift[0] = number(lift, "numerator", 1.12L);
            law.lift[1] = number(lift, "constant", 0.583L);
            law.lift[2] = number(lift, "slope", 2.333L);
        } else if (text_is(lift, "law", "linear")) {
            law.lift_law = LIFT_LINEAR;
            law.lift[0] = number(lift, "slope", 1);
        } else law.lift[0] = number(lift, "value", 0.2L);
    }
    if (wrong[lift_ignored]) law.lift[0] = 0;
    if (wrong[lift_twice]) law.lift[0] *= 2;
    if (wrong[coefficients_swapped]) { real d = law.drag; law.drag = law.lift[0]; law.lift[0] = d; }
    numbers(member(s->air, "wind"), law.wind, 3);
    if (wrong[wind_ignored] || wrong[wind_added_to_ball]) memset(law.wind, 0, sizeof law.wind);
    law.wind_on_drag_only = text_is(s->reading, "wind_acts_on", "drag");
    law.total_spin = text_is(s->reading, "spin_parameter", "total");
    law.up_reading = text_is(s->reading, "lift_direction", "always_up");
    if (spin) {
        law.spinning = true;
        for (int i = 0; i < 3; i++) law.spin[i] = spin[i] * (wrong[spin_in_rpm] ? PI / 30 : 1);
    }

    /* the axis fixed at launch: horizontal, to the right of the heading */
    real along = hypotl(v[0], v[1]), cosine = along > 0 ? v[0] / along : 1, sine = along > 0 ? v[1] / along : 0;
    static real kept[3];
    static bool has_kept;
    law.axis[0] = sine;
    law.axis[1] = -cosine;
    if (wrong[lift_axis_minus_y]) { law.axis[0] = 0; law.axis[1] = -1; }
    if (wrong[state_between_scenes] && has_kept) memcpy(law.axis, kept, sizeof kept);
    kept[0] = sine;
    kept[1] = -cosine;
    has_kept = true;
    law.vertical = law.up_reading && along == 0;
    law.launch_speed = norm(v);
    if (law.spinning) { for (int i = 0; i < 3; i++) law.lift_normal[i] = v[i]; }
    else cross(law.axis, v, law.lift_normal);
    for (int i = 0; i < 3 && law.launch_speed > 0; i++) law.lift_normal[i] /= law.launch_speed;
    return law;
}

/* -------------------------------------------------------------------------------- flight --- */

static real height_above(const State *s, const void *ground) { return s->r[2] - *(const real *)ground; }
static real forward_speed(const State *s, const void *law) {
    const real *axis = ((const Law *)law)->axis;
    real f = -axis[1] * s->v[0] + axis[0] * s->v[1];
    return f;
}
static real backward_speed(const State *s, const void *law) { return -forward_speed(s, law); }

static Instant instant(real t, const State *s) {
    Instant i = {.time = t};
    memcpy(i.r, s->r, sizeof i.r);
    memcpy(i.v, s->v, sizeof i.v);
    return i;
}

/* The signed distance beyond a chord a-b, negative inside the field. */
typedef struct { real a[3], b[3]; } Chord;
static real inside_chord(const State *s, const void *chord) {
    const Chord *c = chord;
    return -((c->b[0] - c->a[0]) * (s->r[1] - c->a[1]) - (c->b[1] - c->a[1]) * (s->r[0] - c->a[0]));
}
static real inside_circle(const State *s, const void *radius) {
    return *(const real *)radius - hypotl(s->r[0], s->r[1]);
}

/* The first crossing of the fence within a step; true if there is one. */
static bool cross_fence(const Scene *scene, const Law *law, const State *s, real t, real h,
                        const State *after, Result *out) {
    const Json *line = member(scene->fence, "polyline");
    real radius = number(scene->fence, "radius", 0), R = scene->R;
    bool found = false;
    State at;
    if (!line) {
        if (inside_circle(s, &radius) > 0 && inside_circle(after, &radius) <= 0) {
            real part = locate(law, s, h, inside_circle, &radius, &at);
            out->at_fence = instant(t + part, &at);
            out->clearance = at.r[2];
            out->segment = 0;
            found = true;
        }
    } else {
        real best = 2 * h;
        int segment = 0;
        for (const Json *p = line->child; p && p->next; p = p->next, segment++) {
            Chord c;
            numbers(p, c.a, 3);
            numbers(p->next, c.b, 3);
            if (!(inside_chord(s, &c) > 0 && inside_chord(after, &c) <= 0)) continue;
            real part = locate(law, s, h, inside_chord, &c, &at);
            real dx = c.b[0] - c.a[0], dy = c.b[1] - c.a[1], length = hypotl(dx, dy);
            real lambda = ((at.r[0] - c.a[0]) * dx + (at.r[1] - c.a[1]) * dy) / (length * length);
            if (!(lambda >= 0 && lambda < 1) || part >= best) continue;
            best = part;
            found = true;
            real top = c.a[2] + lambda * (c.b[2] - c.a[2]);
            if (wrong[fence_height_of_first]) top = c.a[2];
            if (wrong[fence_by_angle]) {
                real from = atan2l(c.a[1], c.a[0]), to = atan2l(c.b[1], c.b[0]);
                top = c.a[2] + (atan2l(at.r[1], at.r[0]) - from) / (to - from) * (c.b[2] - c.a[2]);
            }
            out->at_fence = instant(t + part, &at);
            out->clearance = at.r[2] - top;
            out->segment = segment;
            out->fence_has_margin = true;
            real back = ((c.b[0] - at.r[0]) * dx + (c.b[1] - at.r[1]) * dy) / length;
            out->fence_margin = lambda < 0.5L ? lambda * length : back;
        }
    }
    if (found && (text_is(scene->reading, "fence_clearance", "surface") || wrong[fence_ball_radius]))
        out->clearance -= R;
    return found;
}

/* Fly from s at time t (hang time 0) to the ground. */
static void land(const Scene *scene, State s, real t, const real *spin, Result *out) {
    Law law = law_of(scene, s.v, spin);
    real ground = scene->ground, hang = 0, start = t, limit = scene->time_limit;
    State launch = s;
    if (text_is(scene->reading, "ground_contact", "surface") || wrong[ground_at_radius]) ground += scene->R;
    if (wrong[ground_zero]) ground = 0;
    if (wrong[lands_descending_through_launch]) ground = s.r[2];
    if (wrong[stops_at_20s] && limit > 20) limit = 20;
    const Json *wind = member(scene->air, "wind");
    if (wrong[wind_added_to_ball] && wind) {
        real w[3] = {0};
        numbers(wind, w, 3);
        for (int i = 0; i < 3; i++) s.v[i] += w[i];
    }
    for (;;) {
        real h = step_length(&law, &s);
        if (hang + h > limit) h = limit - hang;
        if (h <= 0) { if (strcmp(out->outcome, "home_run") != 0) out->outcome = "airborne"; return; }
        State after = stepped(&law, s, h);
        bool down = after.r[2] <= ground && after.v[2] <= 0;
        if (law.up_reading && !law.vertical) {
            /* the ball turns vertical: from there on it has no lift (reading always_up) */
            real f0 = forward_speed(&s, &law), f1 = forward_speed(&after, &law);
            if ((f0 > 0 && f1 <= 0) || (f0 < 0 && f1 >= 0)) {
                Law without = law;
                real part = locate(&law, &s, h, f0 > 0 ? forward_speed : backward_speed, &law, &after);
                if (after.r[2] > ground) {
                    s = after;
                    s.v[0] = s.v[1] = 0;
                    hang += part;
                    without.vertical = true;
                    law = without;
                    continue;
                }
            }
        }
        State at;
        real fall = h;
        if (down) {
            fall = locate(&law, &s, h, height_above, &ground, &at);
            at.r[2] = ground;
        }
        if (scene->fence && !out->fence && cross_fence(scene, &law, &s, hang, fall, down ? &at : &after, out)) {
            out->at_fence.time += start;
            bool fair = fabsl(out->at_fence.r[1]) <= out->at_fence.r[0];
            bool circle = !member(scene->fence, "polyline");
            out->fence = true;
            out->fair_known = true;
            out->fair = fair;
            if (out->clearance <= 0 && !wrong[fence_wall_ignored]) { out->outcome = "wall"; return; }
            if (fair || circle) out->outcome = "home_run";
        }
        if (!down) { s = after; hang += h; continue; }
        real time = hang + fall;
        if (wrong[first_below]) { at = after; time = hang + h; }
        if (wrong[last_above]) { at = s; time = hang; }
        if (wrong[linear_landing]) {
            real f = (s.r[2] - ground) / (s.r[2] - after.r[2]);
            for (int i = 0; i < 3; i++) {
                at.r[i] = s.r[i] + f * (after.r[i] - s.r[i]);
                at.v[i] = s.v[i] + f * (after.v[i] - s.v[i]);
            }
            time = hang + f * h;
        }
        if (wrong[clock_step_late]) time += h;
        if (wrong[velocity_stale]) memcpy(at.v, s.v, sizeof at.v);
        out->landing = true;
        out->hang = time;
        out->at_landing = instant(start + time, &at);
        const real *from = text_is(scene->reading, "distance_origin", "launch") ||
                           wrong[distance_from_launch] ? launch.r : still;
        out->distance = hypotl(at.r[0] - from[0], at.r[1] - from[1]);
        if (wrong[distance_3d]) out->distance = norm(at.r);
        if (wrong[distance_x]) out->distance = fabsl(at.r[0]);
        if (spin) { out->spun = true; memcpy(out->spin, spin, sizeof out->spin); }
        if (scene->fence && !out->fair_known) {
            out->fair_known = true;
            out->fair = fabsl(at.r[1]) <= at.r[0];
        }
        return;
    }
}

/* --------------------------------------------------------------------------------- pitch --- */

static real to_plate(const State *s, const void *plate) { return s->r[0] - *(const real *)plate; }

static State released(const Scene *scene) {
    const Json *pitch = member(scene->scene, "pitch");
    State s = {.r = {18.44L, 0, 1.8L}};
    real aim[2] = {0, 1.8L}, speed = number(pitch, "speed", 36.9125L);
    numbers(member(pitch, "release"), s.r, 3);
    numbers(member(pitch, "aim"), aim, 2);
    static real first[3];
    static bool has_first;
    if (!has_first) { memcpy(first, s.r, sizeof first); has_first = true; }
    if (wrong[static_release]) memcpy(s.r, first, sizeof first);
    if (wrong[release_fixed]) { s.r[0] = 18.44L; s.r[1] = 0; s.r[2] = 1.8L; }
    if (wrong[speed_in_kmh]) speed /= 3.6L;
    if (wrong[aim_height_ignored]) aim[1] = s.r[2];
    if (wrong[aim_side_ignored]) aim[0] = s.r[1];
    if (wrong[aim_side_sign]) aim[0] = -aim[0];
    real to[3] = {-s.r[0], aim[0] - s.r[1], aim[1] - s.r[2]}, length = norm(to);
    if (wrong[pitch_speed_horizontal]) length = s.r[0];
    for (int i = 0; i < 3; i++) s.v[i] = speed * to[i] / length;
    if (numbers(member(pitch, "velocity"), s.v, 3) == 3) return s;
    return s;
}

static Law law_of_pitch(const Scene *scene, const State *s, const real *spin) {
    Law law = law_of(scene, s->v, spin);
    if (wrong[pitch_without_lift]) law.lift[0] = 0;
    if (wrong[pitch_without_drag]) law.drag = 0;
    return law;
}

/* Throw to the plane x = 0: "crossed", "grounded" or "airborne". */
static const char *throw_to_plate(const Scene *scene, const real *spin, Result *out) {
    State s = released(scene), at;
    Law law = law_of_pitch(scene, &s, spin);
    State release = s;
    real t = 0, plate = wrong[plate_17_inches] ? 0.4318L : 0;
    real ground = member(scene->scene, "ground") ? scene->ground : 0;
    for (;;) {
        real h = step_length(&law, &s);
        if (t + h > scene->time_limit) h = scene->time_limit - t;
        if (h <= 0) return "airborne";
        State after = stepped(&law, s, h);
        real part = 2 * h, fall = 2 * h;
        State floor_at;
        if (after.r[0] <= plate) part = locate(&law, &s, h, to_plate, &plate, &at);
        if (after.r[2] <= ground && after.v[2] <= 0 && !wrong[ground_ignored_pitch])
            fall = locate(&law, &s, h, height_above, &ground, &floor_at);
        if (fall < part) return "grounded";
        if (part <= h) {
            if (wrong[plate_first_beyond]) { at = after; part = h; }
            if (wrong[plate_velocity_of_release]) memcpy(at.v, release.v, sizeof at.v);
            out->plate = true;
            out->at_plate = instant(t + part, &at);
            return "crossed";
        }
        s = after;
        t += h;
    }
}

/* ------------------------------------------------------------------------------- contact --- */

typedef struct { real reach, height; } Bat;

static real gap(const State *s, const void *bat) {
    const Bat *b = bat;
    return hypotl(s->r[0], s->r[2] - b->height) - b->reach;
}
static real approach(const State *s, const void *bat) { /* falls through 0 at the closest approach */
    const Bat *b = bat;
    return -(s->r[0] * s->v[0] + (s->r[2] - b->height) * s->v[2]);
}

/* Find the first touching of the pitch with the bat's cylinder; false for a miss. */
static bool touch(const Scene *scene, Bat bat, const real *spin, Result *out) {
    State s = released(scene), at;
    Law law = law_of_pitch(scene, &s, spin);
    real t = 0, ground = scene->ground, closest = gap(&s, &bat);
    bool touched = false;
    for (;;) {
        real h = step_length(&law, &s);
        if (t + h > scene->time_limit) h = scene->time_limit - t;
        if (h <= 0) break;
        State after = stepped(&law, s, h);
        bool down = after.r[2] <= ground && after.v[2] <= 0;
        if (down) h = locate(&law, &s, h, height_above, &ground, &after);
        real until = h;
        bool turned = approach(&s, &bat) > 0 && approach(&after, &bat) <= 0;
        State nearest = after;
        if (turned) until = locate(&law, &s, h, approach, &bat, &nearest);
        if (gap(&nearest, &bat) < closest) closest = gap(&nearest, &bat);
        if (!touched && gap(&s, &bat) > 0 && gap(&nearest, &bat) <= 0) {
            real part = locate(&law, &s, until, gap, &bat, &at);
            if (wrong[touching_step_late]) { at = after; part = h; }
            touched = true;
            out->at_contact = instant(t + part, &at);
        }
        if (turned || down || after.r[0] < -bat.reach) break;
        s = after;
        t += h;
    }
    out->margin = true;
    out->contact_margin = -closest;
    if (wrong[margin_sign]) out->contact_margin = closest;
    if (wrong[margin_straight_line]) out->contact_margin = bat.reach - fabsl(out->at_plate.r[2] - bat.height);
    return touched;
}

/* ------------------------------------------------------------------------ oblique impact --- */

/* The bat's compliance at the contact point: [r]^T J^-1 [r], and 1/M for a free bat. */
static void bat_compliance(const Json *bat, const real r[3], bool free_bat, real K[3][3]) {
    real M = number(bat, "mass", 0.9L), L = number(bat, "length", 1), rb = number(bat, "radius", 0.033L);
    real about = free_bat ? M * (L * L / 12 + rb * rb / 4) : M * (L * L / 3 + rb * rb / 4);
    real J[3] = {about, M * rb * rb / 2, about};
    for (int j = 0; j < 3; j++) {
        real e[3] = {j == 0, j == 1, j == 2}, w[3], c[3];
        cross(r, e, w);
        for (int i = 0; i < 3; i++) w[i] /= J[i];
        cross(w, r, c);
        for (int i = 0; i < 3; i++) K[i][j] = c[i] + (free_bat && i == j ? 1 / M : 0);
    }
}

static void solve3(real A[3][3], const real b[3], real x[3]) {
    real c0[3] = {A[0][0], A[1][0], A[2][0]}, c1[3] = {A[0][1], A[1][1], A[2][1]}, c2[3] = {A[0][2], A[1][2], A[2][2]};
    real t[3];
    cross(c1, c2, t);
    real det = dot(c0, t);
    x[0] = dot(b, t) / det;
    cross(b, c2, t);
    x[1] = dot(c0, t) / det;
    cross(c1, b, t);
    x[2] = dot(c0, t) / det;
}

/* -------------------------------------------------------------------------------- impact --- */

/* The impact of a ball at r with v on a bat whose axis has the height zb. */
static const char *strike(const Scene *scene, const real r[3], const real v[3], real zb,
                          const real *spin, Result *out) {
    real M = number(scene->bat, "mass", 0.9L), L = number(scene->bat, "length", 1), rb = number(scene->bat, "radius", 0.033L);
    real omega = number(scene->swing, "angular_speed", 34), theta = number(scene->swing, "tilt", 5 * PI / 180);
    real m = scene->m, R = scene->R, e = scene->e, reach = hypotl(r[0], r[2] - zb), n[3] = {r[0] / reach, 0, (r[2] - zb) / reach};
    const Json *reading = wrong[readings_ignored] ? NULL : scene->reading;
    if (fabsl(r[1]) >= L / 2) return "beyond_bat";
    if (wrong[normal_reversed]) for (int i = 0; i < 3; i++) n[i] = -n[i];
    if (wrong[normal_horizontal]) { n[0] = 1; n[2] = 0; }
    if (wrong[normal_not_unit]) for (int i = 0; i < 3; i++) n[i] *= reach / (2 * R);
    if (wrong[normal_in_three]) {
        real d[3] = {r[0], 0.1L * r[1], r[2] - zb}, size = norm(d);
        for (int i = 0; i < 3; i++) n[i] = d[i] / size;
    }
    if (wrong[normal_from_plate] && out->plate) {
        real s = (out->at_plate.r[2] - zb) / reach;
        if (s > 1) s = 1;
        if (s < -1) s = -1;
        n[2] = s;
        n[0] = sqrtl(1 - s * s);
    }
    if (wrong[swing_fixed_34]) omega = 34;
    if (wrong[tilt_ignored]) theta = 0;
    if (wrong[tilt_sign]) theta = -theta;
    if (wrong[tilt_degrees]) theta = theta * PI / 180;
    real lever = L / 2 - r[1];
    if (wrong[lever_half_length]) lever = L / 2;
    if (wrong[lever_from_other_end]) lever = L / 2 + r[1];
    if (wrong[lever_full_length]) lever = L;
    real reach_of_hand = wrong[lever_offset_hand] ? lever + 0.15L : lever;
    real vb[3] = {omega * reach_of_hand * cosl(theta), 0, omega * reach_of_hand * sinl(theta)};
    if (wrong[tilt_sine_only]) vb[0] = omega * reach_of_hand;
    memcpy(out->normal, n, sizeof n);
    memcpy(out->bat_velocity, vb, sizeof vb);
    out->full_contact = true;
    const real *approaching = wrong[normal_speed_at_plate] && out->plate ? out->at_plate.v : v;
    real relative[3];
    for (int i = 0; i < 3; i++)
        relative[i] = approaching[i] - (wrong[bat_velocity_forgotten] ? 0 : wrong[normal_speed_added] ? -vb[i] : vb[i]);
    real closing = dot(relative, n);
    if (wrong[normal_speed_total]) closing = -norm(relative);
    out->normal_speed = closing;
    if (closing >= 0 && !wrong[separating_struck]) return "separating";

    /* e~ = e (1 + m/M_eff) + m/M_eff, M_eff = I / lever^2 */
    if (wrong[restitution_fixed_042]) e = 0.42L;
    if (wrong[bat_mass_fixed]) M = 0.9L;
    if (wrong[ball_mass_fixed_impact]) m = 0.145L;
    bool free_bat = text_is(scene->bat, "support", "free");
    real I = M * (L * L / 3 + rb * rb / 4);
    if (text_is(reading, "inertia", "thin_rod") || wrong[inertia_rod]) I = M * L * L / 3;
    if (text_is(reading, "inertia", "about_centre") || wrong[inertia_centre]) I = M * (L * L / 12 + rb * rb / 4);
    if (wrong[inertia_fixed_bat]) I = 0.9L * (1.0L / 3 + 0.033L * 0.033L / 4);
    bool printed = text_is(reading, "effective_mass", "as_printed") || wrong[effective_mass_printed];
    real effective = printed ? I / lever : I / (lever * lever);
    if (free_bat) effective = 1 / (1 / M + r[1] * r[1] / (M * (L * L / 12 + rb * rb / 4)));
    real ratio = m / effective;
    if (wrong[mass_ratio_inverted]) ratio = effective / m;
    bool nathan = text_is(reading, "bat_ball_restitution", "nathan"), plain = text_is(reading, "bat_ball_restitution", "plain");
    real et = nathan || plain || wrong[restitution_plain] ? e : e * (1 + ratio) + ratio;
    if (wrong[restitution_minus]) et = e * (1 + ratio) - ratio;
    bool use_effective = nathan || (!plain && text_is(reading, "reduced_mass", "effective_mass")) || wrong[reduced_mass_effective];
    real mu = 1 / (1 / m + 1 / (use_effective ? effective : M));
    if (wrong[reduced_mass_ball]) mu = m;
    if (wrong[reduced_mass_half]) mu = (m + M) / 2;
    real J = -mu * (1 + et) * closing;
    if (wrong[one_plus_forgotten]) J = -mu * et * closing;
    if (wrong[one_minus_restitution]) J = -mu * (1 - et) * closing;
    if (wrong[impulse_of_ball_velocity]) J = -mu * (1 + et) * dot(v, n);
    if (wrong[impulse_sign]) J = -J;
    real energy = -mu * (1 - et * et) * closing * closing / 2;
    if (wrong[energy_without_half]) energy *= 2;
    out->impact = true;
    out->restitution = et;
    real P[3] = {J * n[0], J * n[1], J * n[2]};
    real friction = number(scene->bat, "friction", 0);

    if (friction > 0) {
        real beta = number(scene->ball, "inertia_factor", 0.4L), eT = number(scene->bat, "tangential_restitution", 0.3L);
        if (wrong[friction_inertia_hollow]) beta = 2.0L / 3;
        if (wrong[friction_tangential_default]) eT = 0;
        real K[3][3], knn = 0, arm[3] = {rb * n[0], r[1] - (free_bat ? 0 : L / 2), rb * n[2]};
        bat_compliance(scene->bat, arm, free_bat, K);
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++)
                K[i][j] += (i == j ? 1 / m : 0) + ((i == j) - n[i] * n[j]) / (beta * m);
        for (int i = 0; i < 3; i++) for (int j = 0; j < 3; j++) knn += n[i] * K[i][j] * n[j];
        for (int i = 0; i < 3; i++) for (int j = 0; j < 3; j++) K[i][j] += (1 / mu - knn) * n[i] * n[j];
        /* the slip of the ball's surface on the bat's */
        real turn[3] = {-omega * sinl(theta), 0, omega * cosl(theta)}, g[3], back[3], surface[3];
        real w0[3] = {0, 0, 0}, Rn[3] = {-R * n[0], -R * n[1], -R * n[2]}, rn[3] = {rb * n[0], rb * n[1], rb * n[2]};
        if (spin) memcpy(w0, spin, sizeof w0);
        cross(w0, Rn, back);
        cross(turn, rn, surface);
        if (wrong[friction_no_bat_rotation]) memset(surface, 0, sizeof surface);
        for (int i = 0; i < 3; i++) g[i] = v[i] + back[i] - vb[i] - surface[i];
        real gn = dot(g, n), gt[3], aim[3], grip[3];
        for (int i = 0; i < 3; i++) { gt[i] = g[i] - gn * n[i]; aim[i] = -((1 + et) * gn * n[i] + (1 + eT) * gt[i]); }
        solve3(K, aim, grip);
        real Pn = dot(grip, n), Pt[3];
        for (int i = 0; i < 3; i++) Pt[i] = grip[i] - Pn * n[i];
        out->friction_margin = 1 - norm(Pt) / (friction * Pn);
        out->mode = "grip";
        if (out->friction_margin < 0 && !wrong[friction_always_grips]) {
            out->mode = "slide";
            real d[3], s[3], sum = 0;
            bool last = text_is(reading, "slide_direction", "final");
            for (int i = 0; i < 3; i++) d[i] = last ? -Pt[i] / norm(Pt) : gt[i] / norm(gt);
            for (int i = 0; i < 3; i++) s[i] = n[i] - friction * d[i];
            for (int i = 0; i < 3; i++) for (int j = 0; j < 3; j++) sum += n[i] * K[i][j] * s[j];
            if (sum <= 0) { out->code = "unsupported"; return "struck"; }
            Pn = -(1 + et) * gn / sum;
            for (int i = 0; i < 3; i++) P[i] = Pn * s[i];
        } else memcpy(P, grip, sizeof P);
        real KP[3] = {0}, nP[3];
        for (int i = 0; i < 3; i++) for (int j = 0; j < 3; j++) KP[i] += K[i][j] * P[j];
        energy = 0;
        for (int i = 0; i < 3; i++) energy += P[i] * (g[i] + KP[i] / 2);
        cross(n, P, nP);
        for (int i = 0; i < 3; i++) out->spin_after[i] = w0[i] - (wrong[friction_spin_sign] ? -1 : 1) * nP[i] / (beta * m * R);
        out->oblique = true;
        J = dot(P, n);
    } else if (spin) {
        memcpy(out->spin_after, spin, 3 * sizeof(real));
        out->mode = "frictionless";
        out->oblique = true;
    }
    out->impulse = J;
    for (int i = 0; i < 3; i++) out->after[i] = v[i] + P[i] / (wrong[velocity_by_bat_mass] ? M : scene->m);
    if (wrong[velocity_reflected_whole]) for (int i = 0; i < 3; i++) out->after[i] = -et * v[i] ;
    if (wrong[velocity_relative]) for (int i = 0; i < 3; i++) out->after[i] -= vb[i];
    if (wrong[velocity_bat_added]) for (int i = 0; i < 3; i++) out->after[i] += vb[i];
    if (wrong[velocity_normal_only]) { real s = dot(out->after, n); for (int i = 0; i < 3; i++) out->after[i] = s * n[i]; }
    if (wrong[energy_ball_only]) energy = scene->m * (dot(out->after, out->after) - dot(v, v)) / 2;
    out->energy = energy;
    return "struck";
}

/* ------------------------------------------------------------------------- kinds of scene --- */

static void solve(const Scene *scene, Result *out) {
    const char *kind = member(scene->scene, "kind")->text;
    if (strcmp(kind, "flight") == 0) {
        const Json *launch = member(scene->scene, "launch");
        State s = {.has_before = false};
        real spin[3];
        numbers(member(launch, "position"), s.r, 3);
        numbers(member(launch, "velocity"), s.v, 3);
        bool spins = numbers(member(launch, "spin"), spin, 3) == 3;
        out->outcome = "landed";
        land(scene, s, 0, spins ? spin : NULL, out);
        return;
    }
    const Json *pitch = member(scene->scene, "pitch");
    real spin[3];
    bool spins = numbers(member(pitch, "spin"), spin, 3) == 3;
    if (strcmp(kind, "pitch") == 0) {
        out->outcome = throw_to_plate(scene, spins ? spin : NULL, out);
        return;
    }
    if (strcmp(kind, "impact") == 0) {
        const Json *in = member(scene->scene, "incoming");
        real r[3], v[3];
        numbers(member(in, "position"), r, 3);
        numbers(member(in, "velocity"), v, 3);
        spins = numbers(member(in, "spin"), spin, 3) == 3;
        out->outcome = strike(scene, r, v, number(in, "bat_height", 1), spins ? spin : NULL, out);
        if (strcmp(out->outcome, "beyond_bat") == 0) return;
        out->contact = true;
        memcpy(out->at_contact.r, r, sizeof r);
        return;
    }
    out->outcome = throw_to_plate(scene, spins ? spin : NULL, out);
    if (strcmp(out->outcome, "crossed") != 0) return;
    real offset = number(scene->swing, "height_offset", 0), height = out->at_plate.r[2];
    real aim[2] = {0, 1.8L};
    numbers(member(pitch, "aim"), aim, 2);
    if (wrong[bat_at_aim]) height = aim[1];
    if (wrong[offset_sign]) offset = -offset;
    if (wrong[offset_ignored]) offset = 0;
    real rb = number(scene->bat, "radius", 0.033L);
    Bat bat = {.reach = scene->R + rb, .height = height + offset};
    if (wrong[touching_bat_radius_only]) bat.reach = rb;
    if (wrong[touching_diameters]) bat.reach = 2 * (scene->R + rb);
    out->contact = true;
    bool touched = touch(scene, bat, spins ? spin : NULL, out);
    if (!touched && wrong[missed_as_batted]) { touched = true; out->at_contact = out->at_plate; }
    if (!touched) {
        out->outcome = "missed";
        if (wrong[landing_for_missed]) {
            out->landing = true;
            out->at_landing = out->at_plate;
            out->hang = out->at_plate.time;
        }
        return;
    }
    if (wrong[touching_at_plate]) out->at_contact = out->at_plate;
    out->contact_time = true;
    out->outcome = strike(scene, out->at_contact.r, out->at_contact.v, bat.height, spins ? spin : NULL, out);
    if (strcmp(out->outcome, "struck") != 0) return;
    State s = {.has_before = false};
    memcpy(s.r, out->at_contact.r, sizeof s.r);
    memcpy(s.v, out->after, sizeof s.v);
    out->outcome = "batted";
    bool rubs = number(scene->bat, "friction", 0) > 0 || spins;
    land(scene, s, out->at_contact.time, rubs ? out->spin_after : NULL, out);
}

/* -------------------------------------------------------------------------------- output --- */

static bool comma;

static real shown(real x) { return wrong[rounded_2] ? roundl(x * 100) / 100 : x; }

static const char *spelled(const char *key) {
    if (!wrong[camel_case]) return key;
    if (strcmp(key, "hang_time") == 0) return "hangTime";
    if (strcmp(key, "bat_velocity") == 0) return "batVelocity";
    if (strcmp(key, "normal_speed") == 0) return "normalSpeed";
    if (strcmp(key, "energy_change") == 0) return "energyChange";
    return key;
}

static void put_key(const char *key) {
    printf("%s\"%s\": ", comma ? ", " : "", spelled(key));
    comma = true;
}
static void put_number(const char *key, real x) {
    put_key(key);
    if (isnan((double)x)) printf("NaN");
    else printf(wrong[numbers_as_text] ? "\"%.17Lg\"" : "%.17Lg", shown(x));
}
static void put_vector(const char *key, const real a[3]) {
    put_key(key);
    if (wrong[position_short] && strcmp(key, "position") == 0) printf("[%.17Lg, %.17Lg]", shown(a[0]), shown(a[2]));
    else printf("[%.17Lg, %.17Lg, %.17Lg]", shown(a[0]), shown(a[1]), shown(a[2]));
}
static void put_text(const char *key, const char *text) { put_key(key); printf("\"%s\"", text); }
static void open_block(const char *key) { put_key(key); printf("{"); comma = false; }
static void close_block(void) { printf("}"); comma = true; }

static void put_instant(Instant i, bool time, bool velocity) {
    if (wrong[y_sign]) { i.r[1] = -i.r[1]; i.v[1] = -i.v[1]; }
    if (wrong[axes_yz_swapped]) {
        real y = i.r[1];
        i.r[1] = i.r[2];
        i.r[2] = y;
        y = i.v[1];
        i.v[1] = i.v[2];
        i.v[2] = y;
    }
    if (time) put_number("time", i.time * (wrong[time_ms] ? 1000 : 1));
    put_vector("position", i.r);
    if (velocity) put_vector("velocity", i.v);
}

static void put_result(const char *id, Result *out) {
    printf("{");
    comma = false;
    put_text("id", id);
    if (out->code) {
        put_text("error", "not solved");
        put_text("code", out->code);
        out->impact = false;
    } else put_text("outcome", out->outcome);
    if (wrong[only_outcome]) { printf("}\n"); return; }
    if (out->plate) { open_block("plate"); put_instant(out->at_plate, true, true); close_block(); }
    if (out->contact) {
        open_block("contact");
        if (out->contact_time || out->full_contact) put_instant(out->at_contact, out->contact_time, false);
        if (out->full_contact) {
            put_vector("normal", out->normal);
            put_vector("bat_velocity", out->bat_velocity);
            put_number("normal_speed", out->normal_speed);
        }
        if (out->margin) put_number("margin", out->contact_margin);
        close_block();
    }
    if (out->impact) {
        open_block("impact");
        put_number("restitution", out->restitution);
        put_number("impulse", out->impulse);
        put_vector("velocity", out->after);
        put_number("energy_change", out->energy);
        if (out->oblique) {
            put_vector("spin", out->spin_after);
            put_text("mode", out->mode);
            if (strcmp(out->mode, "frictionless") != 0) put_number("friction_margin", out->friction_margin);
        }
        close_block();
    }
    if (out->fence) {
        open_block("fence");
        put_instant(out->at_fence, true, true);
        put_number("clearance", out->clearance);
        put_number("segment", out->segment);
        if (out->fence_has_margin) put_number("margin", out->fence_margin);
        close_block();
    }
    if (out->landing) {
        Instant at = out->at_landing;
        real hang = out->hang, total = at.time;
        if (wrong[hang_time_total]) hang = total;
        if (wrong[time_is_hang_time]) at.time = out->hang;
        if (wrong[velocity_mph]) for (int i = 0; i < 3; i++) at.v[i] /= 0.44704L;
        if (wrong[landing_speed_sign]) at.v[2] = -at.v[2];
        if (wrong[nan_after_bat] && out->impact) out->distance = NAN;
        if (wrong[random_noise]) out->distance *= 1 + 1e-9L * ((real)rand() / RAND_MAX - 0.5L);
        open_block("landing");
        put_instant(at, true, true);
        put_number("hang_time", hang * (wrong[time_ms] ? 1000 : 1));
        put_number("distance", out->distance / (wrong[distance_feet] ? 0.3048L : 1));
        if (out->spun) put_vector("spin", out->spin);
        if (out->fair_known) { put_key("fair"); printf(out->fair ? "true" : "false"); }
        close_block();
    }
    printf("}\n");
}

static void plant(const char *list) {
    char names[1000];
    snprintf(names, sizeof names, "%s", list);
    for (char *name = strtok(names, ",+"); name; name = strtok(NULL, ",+")) {
        int i = 0;
        while (i < MISTAKE_COUNT && strcmp(mistake_names[i], name) != 0) i++;
        if (i == MISTAKE_COUNT) { fprintf(stderr, "no mistake is called %s\n", name); exit(2); }
        wrong[i] = true;
    }
}

int main(int argc, char **argv) {
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--mistake") == 0 && i + 1 < argc) plant(argv[++i]);
        else if (strcmp(argv[i], "--list") == 0) {
            for (int j = 0; j < MISTAKE_COUNT; j++) puts(mistake_names[j]);
            return 0;
        }
    }
    srand((unsigned)time(NULL) ^ (unsigned)clock());
    if (wrong[prints_banner]) printf("ballistics 1.0\n");
    static char line[1 << 20];
    static Result before;
    static real before_speed = -1;
    while (fgets(line, sizeof line, stdin)) {
        pool_used = 0;
        Json *json;
        parse(line, &json);
        Scene scene = {.scene = json, .ball = member(json, "ball"), .air = member(json, "air"),
                       .bat = member(json, "bat"), .swing = member(json, "swing"), .reading = member(json, "reading"),
                       .fence = member(json, "fence")};
        scene.m = number(scene.ball, "mass", 0.145L);
        scene.R = number(scene.ball, "radius", 0.0366L);
        scene.e = number(scene.ball, "restitution", 0.42L);
        scene.gravity = number(json, "gravity", 9.8L);
        scene.time_limit = number(json, "time_limit", 60);
        if (wrong[time_limit_ignored]) scene.time_limit = 300;
        scene.ground = number(member(json, "ground"), "height", 0);
        static const Json usual_air = {.type = J_OBJECT};
        if (!scene.air) scene.air = &usual_air;
        Result out = {0};
        const Json *id = member(json, "id");
        real key = number(member(json, "pitch"), "speed", 0);
        if (wrong[cached_by_speed] && key > 0 && floorl(key) == before_speed) out = before;
        else if (wrong[refuses_readings] && scene.reading && scene.reading->child) out.code = "unsupported";
        else solve(&scene, &out);
        before = out;
        before_speed = floorl(key);
        put_result(id && id->text ? id->text : "1", &out);
        fflush(stdout);
    }
    return 0;
}
