/* One point of the part in one pixel: its value by the closed form, as depth. */
#include "buffers.glsl"
#include "tiles.h"
#include "surface.glsl"

/* The tool: known when the shader is made, so that nothing is looked up or branched over for what
 * it has not. */
layout(constant_id = 0) const float RING_RADIUS = 0;
layout(constant_id = 1) const float CORNER_RADIUS = 0;
layout(constant_id = 2) const uint HOLLOW = 0;
layout(constant_id = 3) const uint ELEMENTS = 1;
#define BTG_CUTTER   vec4(RING_RADIUS, CORNER_RADIUS, 0, 0)
#define BTG_HOLLOW   (HOLLOW != 0)
#define BTG_ELEMENTS ELEMENTS
#include "ray.glsl"

BTG_BIND(std140, BTG_RASTER_PASS) uniform pass_block {
    btg_raster_pass pass;
};

layout(location = 0) flat in vec4 start;
layout(location = 1) flat in vec3 cell_s; /* from P; DROP has none */
layout(location = 2) flat in vec3 cell_su;
layout(location = 3) flat in vec3 cell_sv;
layout(location = 4) flat in vec3 cell_suu;
layout(location = 5) flat in vec3 cell_suv;
layout(location = 6) flat in vec3 cell_svv;
layout(location = 7) flat in uvec3 corner;
layout(location = 8) flat in vec3 side;
layout(location = 9) flat in vec4 contact;
layout(location = 10) flat in vec3 beat;
layout(location = 11) flat in vec4 within;
layout(location = 12) flat in vec4 slope;
layout(location = 13) flat in vec2 depths;
layout(location = 0) out uvec2 place;

/* Of s and t, for rounding at the edges of cells. */
const float SLACK = 1e-3;

/* A query in its own frame. */
btg_gpu_query frame_query() {
    btg_gpu_query q;
    q.u = vec4(1, 0, 0, beat.x);
    q.v = vec4(0, 1, 0, 0);
    q.w = vec4(0, 0, 1, 0);
    q.origin = q.origin_low = vec4(0);
    q.p = vec4(0, contact.xy, beat.y);
    q.n = vec4(0, contact.zw, 0);
    return q;
}

void main() {
    vec2 pixel = gl_FragCoord.xy - vec2(corner.xy);
    float size = float(pass.size.x);
    if (any(lessThan(pixel, vec2(0))) || any(greaterThan(pixel, vec2(size)))) discard;
    vec2 d = pixel - start.xy;
    vec2 st = start.zw + slope.xy * d.x + slope.zw * d.y;
    if (any(greaterThan(abs(st), vec2(1 + SLACK)))) discard;
    st = clamp(st, -1, 1);
    if (side.x < dot(side.yz, st)) discard;
    btg_surface_point c =
        btg_surface_point(cell_s, cell_su, cell_sv, cell_suu, cell_suv, cell_svv);
    vec3 dp = taylor(c, st.x, st.y);
    btg_gpu_query q = frame_query();
    btg_ray_hit hit;
#ifdef BTG_TILT
    if (dot(dp, dp) - 2 * CORNER_RADIUS * dot(dp, q.n.xyz) < beat.z) discard;
    bool met = cast_circular(q, dp, hit);
#else
    bool met = ray_cast(q, dp, hit);
#endif
    if (!met || hit.value <= beat.x) discard;
    gl_FragDepth = clamp((depths.x - hit.value) * depths.y, 0, 1);
    place = uvec2(corner.z | hit.element << BTG_RASTER_ELEMENT, packSnorm2x16(within.xy + within.zw * st));
}
