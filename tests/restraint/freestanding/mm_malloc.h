/* gcc's headers of vector instructions include this one, which wants stdlib.h. */
