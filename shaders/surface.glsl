/* Points and derivatives of patches and triangles: core/evaluate.c in single precision. */

struct btg_surface_point {
    vec3 s, su, sv, suu, suv, svv; /* s from the query's origin */
};

/* What a place is evaluated with. */
struct btg_item {
    uint item;
    bool triangle;
    uint first;    /* patch: first coefficient; triangle: its cell */
    uint degree_u, degree_v;
    bool rational;
    vec3 offset;   /* patch: origin from the query's origin */
};

btg_item item_of_cell(btg_gpu_query q, uint cell) {
    btg_item i;
    i.item = floatBitsToUint(geometry[cell + 1].w);
    i.triangle = i.item >= scene.counts.x;
    i.first = cell;
    i.degree_u = i.degree_v = 1;
    i.rational = false;
    i.offset = vec3(0);
    if (i.triangle) return i;
    uint at = scene.starts.y + BTG_GPU_PATCH * i.item;
    vec4 high = geometry[at], low = geometry[at + 1];
    uint bits = floatBitsToUint(low.w);
    i.first = floatBitsToUint(high.w);
    i.degree_u = bits & 15u;
    i.degree_v = (bits >> 4) & 15u;
    i.rational = (bits & 256u) != 0;
    i.offset = (high.xyz - q.origin.xyz) + (low.xyz - q.origin_low.xyz);
    return i;
}

/* Value and derivatives of one row's polynomial in t; half the second derivative. */
void row(uint first, uint m, float t, out vec4 p, out vec4 d, out vec4 e) {
    p = geometry[first + m];
    d = e = vec4(0);
    for (uint j = m; j-- > 0;) {
        e = e * t + d;
        d = d * t + p;
        p = p * t + geometry[first + j];
    }
}

/* N/W and its derivatives from those of N and W. */
void quotient(inout btg_surface_point o, vec4 p, vec4 pu, vec4 pv, vec4 puu, vec4 puv, vec4 pvv) {
    float k = 1 / p.w;
    o.s = p.xyz * k;
    o.su = (pu.xyz - o.s * pu.w) * k;
    o.sv = (pv.xyz - o.s * pv.w) * k;
    o.suu = (puu.xyz - 2 * pu.w * o.su - puu.w * o.s) * k;
    o.suv = (puv.xyz - pv.w * o.su - pu.w * o.sv - puv.w * o.s) * k;
    o.svv = (pvv.xyz - 2 * pv.w * o.sv - pvv.w * o.s) * k;
}

btg_surface_point patch_evaluate(btg_item i, float u, float v) {
    float s = u - 0.5, t = v - 0.5;
    vec4 p = vec4(0), pu = vec4(0), puu = vec4(0), pv = vec4(0), puv = vec4(0), pvv = vec4(0);
    for (uint k = i.degree_u + 1; k-- > 0;) {
        vec4 r, d, e;
        row(i.first + k * (i.degree_v + 1), i.degree_v, t, r, d, e);
        puu = puu * s + pu;
        pu = pu * s + p;
        puv = puv * s + pv;
        p = p * s + r;
        pv = pv * s + d;
        pvv = pvv * s + e;
    }
    btg_surface_point o;
    puu *= 2;
    pvv *= 2;
    if (!i.rational) {
        o.s = p.xyz;
        o.su = pu.xyz;
        o.sv = pv.xyz;
        o.suu = puu.xyz;
        o.suv = puv.xyz;
        o.svv = pvv.xyz;
    } else {
        quotient(o, p, pu, pv, puu, puv, pvv);
    }
    o.s += i.offset;
    return o;
}

/* A cell's piece, as derivatives in units of its half sides. */
btg_surface_point cell_evaluate(btg_gpu_query q, uint cell) {
    btg_surface_point o;
    o.s = (geometry[cell].xyz - q.origin.xyz) + (geometry[cell + 1].xyz - q.origin_low.xyz);
    o.su = geometry[cell + 2].xyz;
    o.sv = geometry[cell + 3].xyz;
    o.suu = geometry[cell + 4].xyz;
    o.suv = geometry[cell + 5].xyz;
    o.svv = geometry[cell + 6].xyz;
    return o;
}

btg_surface_point item_evaluate(btg_gpu_query q, btg_item i, float u, float v) {
    if (!i.triangle) return patch_evaluate(i, u, v);
    btg_surface_point o = cell_evaluate(q, i.first);
    float hu = geometry[i.first + 4].w, hv = geometry[i.first + 5].w;
    o.su /= hu;
    o.sv /= hv;
    o.s += o.su * (u - geometry[i.first + 2].w) + o.sv * (v - geometry[i.first + 3].w);
    return o;
}

vec3 taylor(btg_surface_point c, float s, float t) {
    return c.s + (c.su + 0.5 * c.suu * s + c.suv * t) * s + (c.sv + 0.5 * c.svv * t) * t;
}

/* The nearest place of an item's domain. */
vec2 hold(vec2 uv, bool triangle) {
    uv = clamp(uv, 0, 1);
    if (triangle && uv.x + uv.y > 1) {
        uv.x = clamp(0.5 * (1 + uv.x - uv.y), 0, 1);
        uv.y = 1 - uv.x;
    }
    return uv;
}
