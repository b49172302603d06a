#version 450
#extension GL_GOOGLE_include_directive : require
/* Cells of the part into tiles, four vertices each. Geometry is pulled, so that one draw holds any
 * pairs of tile and cell. */
#include "buffers.glsl"
#include "tiles.h"

BTG_BIND(std140, BTG_RASTER_PASS) uniform pass_block {
    btg_raster_pass pass;
};
BTG_BIND(std430, BTG_RASTER_TILES) readonly buffer tile_block {
    btg_raster_tile tiles[];
};
BTG_BIND(std430, BTG_RASTER_LIST) readonly buffer list_block {
    uvec2 list[]; /* tile, cell */
};

out gl_PerVertex {
    vec4 gl_Position;
};
layout(location = 0) flat out vec4 start; /* a pixel, and s, t there */
layout(location = 1) flat out vec3 cell_s; /* from P; DROP has none */
layout(location = 2) flat out vec3 cell_su;
layout(location = 3) flat out vec3 cell_sv;
layout(location = 4) flat out vec3 cell_suu;
layout(location = 5) flat out vec3 cell_suv;
layout(location = 6) flat out vec3 cell_svv;
layout(location = 7) flat out uvec3 corner; /* of the tile; the cell */
layout(location = 8) flat out vec3 side;    /* of a triangle: inside where x > y s + z t */
layout(location = 9) flat out vec4 contact; /* P and its normal, v and w of each */
layout(location = 10) flat out vec3 beat;   /* value; what the tile leaves out */
layout(location = 11) flat out vec4 within; /* of a piece in its cell: s, t at its middle, scale */
layout(location = 12) flat out vec4 slope;  /* of s, t by column, by row */
layout(location = 13) flat out vec2 depths; /* the value of 0, and what a value counts */

/* Vertices stand on the rasteriser's own grid, from the tile's corner: then it does not show where
 * in the atlas the tile is. */
const float GRID = 256;

vec2 view(uint kind, vec3 s) {
    if (kind == BTG_VIEW_PLANE) return s.xy;
    if (kind == BTG_VIEW_CYLINDER) return vec2(s.x, length(s.yz + contact.xy));
    return vec2(s.x, dot(s.yz, vec2(contact.w, -contact.z)));
}

vec2 st_of(uint k) {
    return vec2(k >> 1, k & 1u) * 2 - 1;
}

/* Where a corner of the cell stands in the tile. */
vec2 pixel_of(uint k, btg_raster_tile tile) {
    vec2 st = st_of(k);
    vec3 s = cell_s + (cell_su + 0.5 * cell_suu * st.x + cell_suv * st.y) * st.x +
             (cell_sv + 0.5 * cell_svv * st.y) * st.y;
    vec2 x = (view(tile.at.y, s) - tile.window.xy) / tile.window.zw;
    return round((0.5 + 0.5 * x) * float(pass.size.x) * GRID) / GRID;
}

/* s and t by column and row, where they change by st_a over a and by st_b over b. */
void set_slope(vec2 a, vec2 b, vec2 st_a, vec2 st_b) {
    float area = a.x * b.y - a.y * b.x;
    slope = vec4(0);
    if (area == 0) return;
    slope.xy = (st_a * b.y - st_b * a.y) / area;
    slope.zw = (st_b * a.x - st_a * b.x) / area;
}

/* Corner k of the tile's pixels within half_side of a place, and how many there are. */
vec2 box_corner(uint k, vec2 middle, vec2 half_side, out float area) {
    vec2 least = clamp(floor(middle - half_side), 0, pass.size.x),
         most = clamp(ceil(middle + half_side), 0, pass.size.x);
    area = (most.x - least.x) * (most.y - least.y);
    return mix(least, most, 0.5 + 0.5 * st_of(k));
}

/* Two triangles, 0 1 2 and 2 1 3: of the cell's corners; or, where much of them would fall beside
 * the tile, of its pixels about the cell. s and t are then as they change at the cell's middle: that
 * a point is shown beside its pixel takes nothing from what it tells. */
vec2 corner_of(uint k, btg_raster_tile tile) {
    vec2 c[4];
    for (uint i = 0u; i < 4u; i++)
        c[i] = pixel_of(i, tile);
    vec2 middle = 0.25 * (c[0] + c[1] + c[2] + c[3]), a = 0.25 * (c[2] + c[3] - c[0] - c[1]),
         b = 0.25 * (c[1] + c[3] - c[0] - c[2]);
    float area;
    vec2 at = box_corner(k, middle, abs(a) + abs(b), area);
    if (area < 4 * abs(a.x * b.y - a.y * b.x)) {
        start = vec4(middle, 0, 0);
        set_slope(a, b, vec2(1, 0), vec2(0, 1));
        return at;
    }
    uint other = k == 2u ? 0u : 2u;
    start = vec4(c[k], st_of(k));
    set_slope(c[1] - c[k], c[other] - c[k], st_of(1u) - st_of(k), st_of(other) - st_of(k));
    return c[k];
}

void main() {
    uint index = uint(gl_VertexID);
    uvec2 entry = list[index / 4u];
    btg_raster_tile tile = tiles[entry.x];
    btg_gpu_query q = queries[tile.at.x];
    uint cell = scene.starts.x + BTG_GPU_CELL * entry.y;

    vec4 high = geometry[cell], low = geometry[cell + 1], su = geometry[cell + 2],
         sv = geometry[cell + 3], suu = geometry[cell + 4], suv = geometry[cell + 5],
         svv = geometry[cell + 6];
    mat3 frame = transpose(mat3(q.u.xyz, q.v.xyz, q.w.xyz));
    vec3 p_low = vec3(q.v.w, q.w.w, q.n.w);
    cell_s = frame * ((high.xyz - q.origin.xyz - q.p.xyz) + (low.xyz - q.origin_low.xyz - p_low));
    cell_su = frame * su.xyz;
    cell_sv = frame * sv.xyz;
    cell_suu = frame * suu.xyz;
    cell_suv = frame * suv.xyz;
    cell_svv = frame * svv.xyz;
    bool triangle = floatBitsToUint(low.w) >= scene.counts.x;
    side = triangle ? vec3(1 - su.w - sv.w, suu.w, suv.w) : vec3(1, 0, 0);
    vec3 p = frame * q.p.xyz, n = frame * q.n.xyz;
    contact = vec4(p.yz, n.yz);
    beat = vec3(q.u.w, tile.limits.xy);
    depths = tile.limits.zw;
    corner = uvec3(tile.at.zw, entry.y);
    within = vec4(0, 0, 1, 1);
    if (entry.y >= pass.size.z) {
        corner.z = floatBitsToUint(svv.w);
        uint whole = scene.starts.x + BTG_GPU_CELL * corner.z;
        vec2 h = vec2(geometry[whole + 4].w, geometry[whole + 5].w);
        within.xy = (vec2(su.w, sv.w) - vec2(geometry[whole + 2].w, geometry[whole + 3].w)) / h;
        within.zw = vec2(suu.w, suv.w) / h;
    }

    uint k = index & 3u;
    vec2 at = corner_of(k, tile);
    gl_Position = vec4((vec2(tile.at.zw) + at) * pass.scale.xy - 1, 0, 1);
}
