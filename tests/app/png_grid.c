/* What is in a picture, coarsely: a PNG in cells, the mean colour of each and how much of it has
 * the colours of P and Q. For tests that compare pictures by structure, not by bytes.
 *
 *   png_grid FILE COLUMNS ROWS      column,row,red,green,blue,p,q: 0 .. 255, shares in percent */
#include "io/palette.h"

#include <cairo.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NEAR 30 /* a colour this close in all three counts as the same */

static const double marks[2][3] = {{BTG_RGB_P}, {BTG_RGB_Q}};

static int is_mark(const int rgb[3], const double mark[3]) {
    for (int k = 0; k < 3; k++)
        if (abs(rgb[k] - (int)(255 * mark[k] + 0.5)) > NEAR) return 0;
    return 1;
}

static void print_cell(cairo_surface_t *image, int columns, int rows, int column, int row) {
    int width = cairo_image_surface_get_width(image),
        height = cairo_image_surface_get_height(image);
    int stride = cairo_image_surface_get_stride(image);
    const unsigned char *data = cairo_image_surface_get_data(image);
    long sum[3] = {0, 0, 0}, marked[2] = {0, 0}, count = 0;
    for (int y = row * height / rows; y < (row + 1) * height / rows; y++)
        for (int x = column * width / columns; x < (column + 1) * width / columns; x++) {
            uint32_t pixel;
            memcpy(&pixel, data + (size_t)y * (size_t)stride + 4 * (size_t)x, sizeof pixel);
            const int rgb[3] = {(int)(pixel >> 16 & 255), (int)(pixel >> 8 & 255),
                                (int)(pixel & 255)};
            for (int k = 0; k < 3; k++)
                sum[k] += rgb[k];
            for (int k = 0; k < 2; k++)
                marked[k] += is_mark(rgb, marks[k]);
            count++;
        }
    printf("%d,%d,%.1f,%.1f,%.1f,%.2f,%.2f\n", column, row, (double)sum[0] / (double)count,
           (double)sum[1] / (double)count, (double)sum[2] / (double)count,
           100.0 * (double)marked[0] / (double)count, 100.0 * (double)marked[1] / (double)count);
}

int main(int count, char **words) {
    int columns = count == 4 ? atoi(words[2]) : 0, rows = count == 4 ? atoi(words[3]) : 0;
    if (columns < 1 || rows < 1) return 2;
    cairo_surface_t *image = cairo_image_surface_create_from_png(words[1]);
    if (cairo_surface_status(image) != CAIRO_STATUS_SUCCESS) return 1;
    printf("column,row,red,green,blue,p,q\n");
    for (int row = 0; row < rows; row++)
        for (int column = 0; column < columns; column++)
            print_cell(image, columns, rows, column, row);
    cairo_surface_destroy(image);
    return 0;
}
