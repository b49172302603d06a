/* Vertical and circular rays against a cutter: core/ray.c in single precision, same names, same
 * order. Points are given from the query's origin. */

/* The tool, for who knows it before the shader is made. */
#ifndef BTG_CUTTER
#define BTG_CUTTER   scene.element[0]
#define BTG_HOLLOW   (scene.counts.w != 0)
#define BTG_ELEMENTS scene.counts.z
#endif

const float PI = 3.14159265358979;

/* Power of a point that is rounding, part of the squared minor radius: the coordinates have seven
 * digits. */
const float INSIDE = 3e-6;

struct btg_ray_hit {
    float value;
    uint element;
};

/* atan2 to a few 1e-7: Vulkan allows the built-in one an error of 4096 units in the last place.
 * Series about the quarter's middle: atan(z) = pi/4 + atan((z - 1) / (z + 1)). */
float angle(float y, float x) {
    float ax = abs(x), ay = abs(y), low = min(ax, ay), high = max(ax, ay);
    if (high == 0) return 0;
    bool upper = low > 0.41421356 * high;
    float z = (upper ? low - high : low) / (upper ? low + high : high), z2 = z * z;
    float a = ((8.05374449538e-2 * z2 - 1.38776856032e-1) * z2 + 1.99777106478e-1) * z2;
    a = (a - 3.33329491539e-1) * z2 * z + z;
    if (upper) a += 0.25 * PI;
    if (ay > ax) a = 0.5 * PI - a;
    if (x < 0) a = PI - a;
    return y < 0 ? -a : a;
}

/* ---- DROP ---- */

bool profile_depth(vec4 e, bool hollow, float r, out float depth) {
    float x = r - e.x;
    if (!hollow && x < 0) x = 0;
    float inner2 = (e.y - x) * (e.y + x);
    depth = inner2 < 0 ? 0 : sqrt(inner2) - e.z;
    return inner2 >= 0;
}

/* The value of a point, or of a ball an upper bound: the element offset by its radius. */
bool cast_vertical(btg_gpu_query q, vec3 s, float radius, out btg_ray_hit hit) {
    float height = dot(s, q.w.xyz), r = length(s - q.w.xyz * height), depth;
    bool found = profile_depth(BTG_CUTTER + vec4(0, radius, 0, 0), BTG_HOLLOW, r, depth);
    hit.value = height + depth;
    hit.element = 0;
    /* The cutter stands apart: what an index that varies picks from a uniform block is slow. */
    for (uint i = 1; i < BTG_ELEMENTS; i++) {
        vec4 e = scene.element[i];
        e.y += radius;
        if (!profile_depth(e, false, r, depth)) continue;
        if (found && height + depth <= hit.value) continue;
        hit.value = height + depth;
        hit.element = i;
        found = true;
    }
    return found;
}

/* ---- TILT ---- */

struct circle {
    float su, sv, sw, radius;
    float d;
};

float turn(circle c, float tv, float tw) {
    return angle(c.sv * tw - c.sw * tv, c.sv * tv + c.sw * tw);
}

/* turn(c, tv, tw) > INSIDE, without the angle. */
bool turned(circle c, float tv, float tw) {
    return c.sv * tw - c.sw * tv > max(INSIDE * (c.sv * tv + c.sw * tw), 0);
}

bool cast_torus(vec4 e, circle c, out float value) {
    float ro = e.x, ri = e.y;
    value = PI;
    if (ro <= 0 || ri <= 0) return false;
    if (c.d <= INSIDE * ri * ri) return c.d < -INSIDE * ri * ri;
    float tv = ro + c.d / (4 * ro) - ro * c.su * c.su / c.d;
    if (!(tv <= c.radius)) return false;
    tv = max(tv, -c.radius);
    float tw = sqrt((c.radius - tv) * (c.radius + tv)), beta = turn(c, tv, -tw);
    if (c.sw > 0) {
        bool inside = turned(c, tv, tw);
        if (inside && beta > 0) beta -= 2 * PI;
        if (!inside && beta < 0) beta += 2 * PI;
    }
    value = -beta;
    return true;
}

bool cast_flat(vec4 e, circle c, out float value) {
    value = 0;
    if (c.radius < e.y) return false;
    float tv = sqrt((c.radius - e.y) * (c.radius + e.y));
    if (c.su * c.su + (tv - e.x) * (tv - e.x) > e.x * e.x) return false;
    float beta = turn(c, tv, -e.y);
    if (c.sw > 0 && beta < 0) beta += 2 * PI;
    value = -beta;
    return true;
}

float entry(circle c, float tv, float tw, bool inside) {
    float beta = turn(c, tv, tw);
    return beta < 0 && !inside ? beta + 2 * PI : beta;
}

bool cast_cylinder(vec4 e, float major, circle c, out float value) {
    value = 0;
    float c2 = e.x * e.x - c.su * c.su;
    if (c2 < 0) return false;
    float half_side = sqrt(c2), near_v = major - half_side, far_v = major + half_side;
    float slack = INSIDE * e.x, r2 = c.radius * c.radius;
    bool inside = c.sv > near_v - slack && c.sv < far_v + slack && c.sw > e.z - slack &&
                  c.sw < e.w + slack;
    bool found = false;
    if (r2 >= e.z * e.z) {
        float tv = sqrt(r2 - e.z * e.z);
        if (tv >= near_v && tv <= far_v) {
            value = -entry(c, tv, e.z, inside);
            found = true;
        }
    }
    if (r2 >= far_v * far_v) {
        float tw = sqrt(r2 - far_v * far_v);
        if (tw >= e.z && tw <= e.w) {
            float side = -entry(c, far_v, tw, inside);
            if (!found || side > value) value = side;
            found = true;
        }
    }
    return found;
}

/* The circle's elements, offset by radius. */
bool cast_elements(circle c, float radius, out btg_ray_hit hit) {
    float value;
    vec4 cutter = BTG_CUTTER + vec4(0, radius, 0, 0);
    bool found = cast_torus(cutter, c, hit.value);
    if (!BTG_HOLLOW && cast_flat(cutter, c, value)) {
        if (!found || value > hit.value) hit.value = value;
        found = true;
    }
    hit.element = 0;
    for (uint i = 1; i < BTG_ELEMENTS; i++) {
        vec4 e = scene.element[i] + vec4(radius, 0, -radius, radius);
        if (!cast_cylinder(e, cutter.x, c, value)) continue;
        if (found && value <= hit.value) continue;
        hit.value = value;
        hit.element = i;
        found = true;
    }
    return found;
}

circle circle_of(btg_gpu_query q, vec3 s) {
    circle c;
    c.su = dot(s, q.u.xyz);
    c.sv = dot(s, q.v.xyz);
    c.sw = dot(s, q.w.xyz);
    c.radius = sqrt(c.sv * c.sv + c.sw * c.sw);
    return c;
}

/* dp: the point from P, so that near P it keeps its digits. */
bool cast_circular(btg_gpu_query q, vec3 dp, out btg_ray_hit hit) {
    float dp2 = dot(dp, dp);
    hit.value = 0;
    hit.element = 0;
    if (dp2 < q.p.w) return false;
    circle c = circle_of(q, q.p.xyz + dp);
    /* d from P, not from O1: near P the difference of two squares would lose all digits. */
    c.d = dp2 - 2 * BTG_CUTTER.y * dot(dp, q.n.xyz);
    return cast_elements(c, 0, hit);
}

bool ball_circular(btg_gpu_query q, vec3 s, float radius, out float value) {
    circle c = circle_of(q, s);
    float corner = BTG_CUTTER.y + radius;
    c.d = c.su * c.su + c.radius * c.radius - corner * corner;
    value = PI;
    if (c.d <= INSIDE * corner * corner) return true; /* it reaches the insert's sphere */
    btg_ray_hit hit;
    bool met = cast_elements(c, radius, hit);
    value = hit.value;
    return met;
}

/* ---- both ---- */

bool ray_cast(btg_gpu_query q, vec3 s, out btg_ray_hit hit) {
#ifdef BTG_TILT
    return cast_circular(q, s - q.p.xyz, hit);
#else
    return cast_vertical(q, s, 0, hit);
#endif
}

bool ray_ball_value(btg_gpu_query q, vec3 s, float radius, out float value) {
#ifdef BTG_TILT
    return ball_circular(q, s, radius, value);
#else
    btg_ray_hit hit;
    bool met = cast_vertical(q, s, radius, hit);
    value = hit.value;
    return met;
#endif
}
