/* What sampling by pixels and facets costs: M. Singh, S. Bedi, S. Mann, "A GPU Method and Error
 * Analysis of Multi-Point Positioning of a Toroidal Tool for 5-Axis Machining", 2024, sections 6 to
 * 9. Lengths in mm. */
#ifndef BTG_METHODS_ERROR_MODEL_H
#define BTG_METHODS_ERROR_MODEL_H

/* Equation 2: how deep a tool dropped by pixels may be in the part for the insert's roundness, with
 * the contact at `x` (0 .. minor_radius, 0 its lowest point) and pixels `pitch` wide; at the side
 * pitch / 4. */
double btg_pixel_error(double minor_radius, double x, double pitch);

/* The same for the tool's roundness about its axis, which the paper leaves out. */
double btg_pixel_error_around(double major_radius, double minor_radius, double x, double pitch);

/* Both, wherever the contact lies between pixels, and however these are turned to the insert, on a
 * part that is round too: `bulge`, 1/mm, is its greatest curvature away from the tool, 0 where it
 * curves to the tool. The paper's parts are flat. */
double btg_pixel_bound(double major_radius, double minor_radius, double x, double pitch,
                       double bulge);

/* The widest pixels, window of the tool's width, whose bound is at most `error`. */
double btg_pixel_pitch(double major_radius, double minor_radius, double x, double bulge,
                       double error);

/* Sides of facets whose sagitta is at most `error` on a circle. */
double btg_facet_length(double radius, double error);

#endif
