#include "conformance.h"
const case_list cases_random = {0, 0};
