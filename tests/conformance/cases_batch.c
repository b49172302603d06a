#include "conformance.h"
const case_list cases_batch = {0, 0};
