#include "conformance.h"
const case_list cases_edge = {0, 0};
