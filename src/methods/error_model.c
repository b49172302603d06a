#include "methods/error_model.h"

#include <math.h>

/* Heights are equal within that part when a pitch is sought. */
#define HALVINGS 60

double btg_pixel_error(double minor_radius, double x, double pitch) {
    /* dy of equation 1, from the pixel before; on the other side of the lowest point it is less. */
    double near = x - pitch, r2 = minor_radius * minor_radius;
    double far_height = x < minor_radius ? sqrt(r2 - x * x) : 0;
    double near_height = near > -minor_radius ? sqrt(r2 - near * near) : 0;
    double dy = near > 0 ? near_height - far_height : minor_radius - far_height;
    return (pitch * pitch + dy * dy) / (8 * minor_radius);
}

double btg_pixel_error_around(double major_radius, double minor_radius, double x, double pitch) {
    /* Normal curvature of the torus along its circle: sin(theta) / r. */
    return pitch * pitch / 8 * (x / minor_radius) / (major_radius + x);
}

double btg_pixel_bound(double major_radius, double minor_radius, double x, double pitch,
                       double bulge) {
    /* Pixels are that far apart across their corners, and the contact may be at either end. */
    double apart = sqrt(2) * pitch, far = fmin(x + apart, minor_radius);
    /* Curvatures of insert and part add where these turn away from each other. */
    return btg_pixel_error(minor_radius, far, apart) * (1 + bulge * minor_radius) +
           btg_pixel_error_around(major_radius, minor_radius, far, apart);
}

double btg_pixel_pitch(double major_radius, double minor_radius, double x, double bulge,
                       double error) {
    double fine = 0, coarse = minor_radius;
    for (int k = 0; k < HALVINGS; k++) {
        double middle = 0.5 * (fine + coarse);
        if (btg_pixel_bound(major_radius, minor_radius, x, middle, bulge) <= error)
            fine = middle;
        else
            coarse = middle;
    }
    return fine;
}

double btg_facet_length(double radius, double error) {
    return 2 * sqrt(2 * error * radius);
}
