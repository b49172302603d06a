#include "core/part.h"

#include <stdio.h>
#include <string.h>

#define TOOL_DEF_VERSION 1

btg_tool_def btg_tool_def_default(void) {
    btg_tool_def def;
    memset(&def, 0, sizeof def);
    def.version = TOOL_DEF_VERSION;
    def.profile = BTG_PROFILE_TOROIDAL;
    def.major_radius_mm = 6.7;
    def.minor_radius_mm = 6.0;
    return def;
}

static btg_status check_length(const char *name, double value, btg_message *message) {
    if (!isfinite(value)) {
        return btg_fail(message, BTG_ERROR_ARGUMENT, "tool: %s is not a finite number", name);
    }
    if (value < 0) {
        return btg_fail(message, BTG_ERROR_ARGUMENT, "tool: %s is %g mm; give 0 or more", name,
                        value);
    }
    if (value > BTG_LENGTH_MAX) {
        return btg_fail(message, BTG_ERROR_ARGUMENT, "tool: %s is %g mm; give at most %g", name,
                        value, BTG_LENGTH_MAX);
    }
    return BTG_OK;
}

static btg_status check_cutter(const btg_tool_def *def, btg_message *message) {
    if (def->profile != BTG_PROFILE_TOROIDAL && def->profile != BTG_PROFILE_BULLNOSE) {
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "tool: unknown profile; give toroidal or bullnose");
    }
    btg_status status = check_length("major radius", def->major_radius_mm, message);
    if (status == BTG_OK) status = check_length("minor radius", def->minor_radius_mm, message);
    if (status != BTG_OK) return status;
    if (def->major_radius_mm == 0 && def->minor_radius_mm == 0) {
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "tool: both radii are 0; one of them must be positive");
    }
    if (def->profile == BTG_PROFILE_TOROIDAL && def->minor_radius_mm == 0) {
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "tool: a toroidal cutter needs a minor radius above 0; a flat end mill is "
                        "bullnose");
    }
    return BTG_OK;
}

static btg_status check_cylinder(const char *name, const btg_cylinder *c, btg_message *message) {
    char what[64];
    const double value[3] = {c->radius_mm, c->from_mm, c->to_mm};
    const char *const part[3] = {"radius", "lower height", "upper height"};
    for (int i = 0; i < 3; i++) {
        snprintf(what, sizeof what, "%s: %s", name, part[i]);
        btg_status status = check_length(what, value[i], message);
        if (status != BTG_OK) return status;
    }
    if (c->radius_mm == 0) {
        return btg_fail(message, BTG_ERROR_ARGUMENT, "tool: %s: radius is 0; give more", name);
    }
    if (c->from_mm >= c->to_mm) {
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "tool: %s reaches from %g mm to %g mm; the first height must be the lower",
                        name, c->from_mm, c->to_mm);
    }
    return BTG_OK;
}

static btg_status check(const btg_tool_def *def, btg_message *message) {
    if (def->version != TOOL_DEF_VERSION) {
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "tool: unknown version; start from btg_tool_def_default()");
    }
    btg_status status = check_cutter(def, message);
    if (status != BTG_OK) return status;
    if (def->shank.radius_mm != 0) status = check_cylinder("shank", &def->shank, message);
    if (status != BTG_OK) return status;
    if (def->holder_count > BTG_HOLDER_MAX) {
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "tool: the holder has %lu cylinders; give at most %d",
                        (unsigned long)def->holder_count, BTG_HOLDER_MAX);
    }
    for (uint32_t i = 0; i < def->holder_count && status == BTG_OK; i++) {
        char name[32];
        snprintf(name, sizeof name, "holder %lu", (unsigned long)i + 1);
        status = check_cylinder(name, &def->holder[i], message);
    }
    return status;
}

static btg_tool_element cylinder_element(const btg_cylinder *c) {
    return (btg_tool_element){
        .ring_radius_mm = c->radius_mm, .from_mm = c->from_mm, .to_mm = c->to_mm};
}

btg_status btg_tool_init(const btg_tool_def *def, btg_tool *tool, btg_message *message) {
    if (!def || !tool) {
        return btg_fail(message, BTG_ERROR_ARGUMENT, "tool: definition or result is NULL");
    }
    btg_status status = check(def, message);
    if (status != BTG_OK) return status;
    btg_tool t;
    memset(&t, 0, sizeof t);
    t.def = *def;
    t.element[t.element_count++] = (btg_tool_element){
        .ring_radius_mm = def->major_radius_mm,
        .corner_radius_mm = def->minor_radius_mm,
        .to_mm = INFINITY,
        .hollow = def->profile == BTG_PROFILE_TOROIDAL && def->major_radius_mm > 0};
    if (def->shank.radius_mm > 0) t.element[t.element_count++] = cylinder_element(&def->shank);
    for (uint32_t i = 0; i < def->holder_count; i++) {
        t.element[t.element_count++] = cylinder_element(&def->holder[i]);
    }
    *tool = t;
    return BTG_OK;
}

double btg_tool_distance(const btg_tool *tool, btg_vec3 torus_centre, btg_vec3 axis,
                         btg_vec3 point) {
    btg_vec3 d = vec_sub(point, torus_centre);
    double height = vec_dot(d, axis);
    double r = vec_norm(vec_mad(d, axis, -height));
    double least = INFINITY;
    for (uint32_t i = 0; i < tool->element_count; i++) {
        const btg_tool_element *e = &tool->element[i];
        double x = r - e->ring_radius_mm, distance;
        if (i == 0) {
            if (!e->hollow && x < 0) x = 0;
            distance = hypot(x, height) - e->corner_radius_mm;
        } else {
            double below = e->from_mm - height, above = height - e->to_mm;
            double z = below > above ? below : above;
            distance = x > 0 && z > 0 ? hypot(x, z) : (x > z ? x : z);
        }
        if (distance < least) least = distance;
    }
    return least;
}
