#include "shapes.h"

static const struct {
    double major, minor;
    btg_profile profile;
} tools[SHAPE_TOOLS] = {
    {6.7, 6, BTG_PROFILE_TOROIDAL}, {2, 5, BTG_PROFILE_TOROIDAL},   {10, 3, BTG_PROFILE_TOROIDAL},
    {5, 5, BTG_PROFILE_TOROIDAL},   {6.7, 6, BTG_PROFILE_BULLNOSE}, {8, 1, BTG_PROFILE_BULLNOSE},
    {6, 0, BTG_PROFILE_BULLNOSE},   {0, 6, BTG_PROFILE_TOROIDAL},
};

void shape_tool(fixture *f, int number) {
    int i = number % SHAPE_TOOLS;
    fixture_tool(f, tools[i].major, tools[i].minor, tools[i].profile);
}

double shape_gap(const fixture *f, double e) {
    double gap = e - f->tool.def.major_radius_mm;
    return f->tool.def.profile == BTG_PROFILE_BULLNOSE ? fmax(0, gap) : fabs(gap);
}
