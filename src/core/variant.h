/* Names for a second build of the run phase in one library: included before its sources, with
 * BTG_VARIANT the ending of their names. Internal. */
#ifndef BTG_CORE_VARIANT_H
#define BTG_CORE_VARIANT_H

#define BTG_VARIANT_PASTE(name, variant) name##_##variant
#define BTG_VARIANT_JOIN(name, variant)  BTG_VARIANT_PASTE(name, variant)
#define BTG_VARIANT_TEXT(x)              #x
#define BTG_VARIANT_STRING(x)            BTG_VARIANT_TEXT(x)
#define BTG_VARIANT_NAME                 BTG_VARIANT_STRING(BTG_VARIANT)
#define BTG_RUN_THIS                     BTG_VARIANT_JOIN(btg_run, BTG_VARIANT)

#define btg_basin_make                 BTG_VARIANT_JOIN(btg_basin_make, BTG_VARIANT)
#define btg_basins_cover               BTG_VARIANT_JOIN(btg_basins_cover, BTG_VARIANT)
#define btg_block_bounds               BTG_VARIANT_JOIN(btg_block_bounds, BTG_VARIANT)
#define btg_block_quarter              BTG_VARIANT_JOIN(btg_block_quarter, BTG_VARIANT)
#define btg_block_of_node              BTG_VARIANT_JOIN(btg_block_of_node, BTG_VARIANT)
#define btg_block_of_triangles         BTG_VARIANT_JOIN(btg_block_of_triangles, BTG_VARIANT)
#define btg_cell_of_child              BTG_VARIANT_JOIN(btg_cell_of_child, BTG_VARIANT)
#define btg_block_make                 BTG_VARIANT_JOIN(btg_block_make, BTG_VARIANT)
#define btg_cell_clear_to_second_order BTG_VARIANT_JOIN(btg_cell_clear_to_second_order, BTG_VARIANT)
#define btg_cell_of_block              BTG_VARIANT_JOIN(btg_cell_of_block, BTG_VARIANT)
#define btg_cell_of_triangle           BTG_VARIANT_JOIN(btg_cell_of_triangle, BTG_VARIANT)
#define btg_cell_place                 BTG_VARIANT_JOIN(btg_cell_place, BTG_VARIANT)
#define btg_cell_radius                BTG_VARIANT_JOIN(btg_cell_radius, BTG_VARIANT)
#define btg_cell_reach                 BTG_VARIANT_JOIN(btg_cell_reach, BTG_VARIANT)
#define btg_part_point                 BTG_VARIANT_JOIN(btg_part_point, BTG_VARIANT)
#define btg_patch_evaluate             BTG_VARIANT_JOIN(btg_patch_evaluate, BTG_VARIANT)
#define btg_patch_evaluate_four        BTG_VARIANT_JOIN(btg_patch_evaluate_four, BTG_VARIANT)
#define btg_piece_cut                  BTG_VARIANT_JOIN(btg_piece_cut, BTG_VARIANT)
#define btg_piece_root                 BTG_VARIANT_JOIN(btg_piece_root, BTG_VARIANT)
#define btg_ray_ball_value             BTG_VARIANT_JOIN(btg_ray_ball_value, BTG_VARIANT)
#define btg_ray_cast                   BTG_VARIANT_JOIN(btg_ray_cast, BTG_VARIANT)
#define btg_ray_osculating             BTG_VARIANT_JOIN(btg_ray_osculating, BTG_VARIANT)
#define btg_ray_place                  BTG_VARIANT_JOIN(btg_ray_place, BTG_VARIANT)
#define btg_ray_query_drop             BTG_VARIANT_JOIN(btg_ray_query_drop, BTG_VARIANT)
#define btg_ray_query_tilt             BTG_VARIANT_JOIN(btg_ray_query_tilt, BTG_VARIANT)
#define btg_ray_ridge                  BTG_VARIANT_JOIN(btg_ray_ridge, BTG_VARIANT)
#define btg_ray_tool_distance          BTG_VARIANT_JOIN(btg_ray_tool_distance, BTG_VARIANT)
#define btg_ray_tool_limit             BTG_VARIANT_JOIN(btg_ray_tool_limit, BTG_VARIANT)
#define btg_search_clear               BTG_VARIANT_JOIN(btg_search_clear, BTG_VARIANT)
#define btg_search_clear_piece         BTG_VARIANT_JOIN(btg_search_clear_piece, BTG_VARIANT)
#define btg_search_deep_at_p           BTG_VARIANT_JOIN(btg_search_deep_at_p, BTG_VARIANT)
#define btg_search_near_p              BTG_VARIANT_JOIN(btg_search_near_p, BTG_VARIANT)
#define btg_search_offer               BTG_VARIANT_JOIN(btg_search_offer, BTG_VARIANT)
#define btg_search_polish              BTG_VARIANT_JOIN(btg_search_polish, BTG_VARIANT)
#define btg_search_polish_rim          BTG_VARIANT_JOIN(btg_search_polish_rim, BTG_VARIANT)
#define btg_search_run                 BTG_VARIANT_JOIN(btg_search_run, BTG_VARIANT)
#define btg_search_sheet_at_p          BTG_VARIANT_JOIN(btg_search_sheet_at_p, BTG_VARIANT)
#define btg_search_stack_size          BTG_VARIANT_JOIN(btg_search_stack_size, BTG_VARIANT)
#define btg_triangle_cut               BTG_VARIANT_JOIN(btg_triangle_cut, BTG_VARIANT)
#define btg_triangle_root              BTG_VARIANT_JOIN(btg_triangle_root, BTG_VARIANT)

#endif
