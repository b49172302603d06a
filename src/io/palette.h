/* Colours that mean the same in every picture, red, green and blue in 0 .. 1. P and Q are Okabe and
 * Ito's: told apart with any colour vision. Internal to the program. */
#ifndef BTG_IO_PALETTE_H
#define BTG_IO_PALETTE_H

#define BTG_RGB_P          0.000, 0.447, 0.698
#define BTG_RGB_Q          0.835, 0.369, 0.000
#define BTG_RGB_OSCULATING 0.545, 0.110, 0.420
#define BTG_RGB_SINGLE     0.050, 0.050, 0.050
#define BTG_RGB_INK        0.130, 0.150, 0.180

#endif
