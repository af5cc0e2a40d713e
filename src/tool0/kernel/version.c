/* Digest of the sources from which this library was compiled; build.py searches for it
   in the file. */
#include <float.h>

#include "export.h"

/* Results are equal to those of Python's floats, since intermediate results do not have
   more bits. */
_Static_assert(FLT_EVAL_METHOD == 0, "need double arithmetic without excess precision");
_Static_assert(sizeof(double) == 8, "need doubles of 64 bits");

TOOL0_EXPORT const char tool0_kernel_digest[] = TOOL0_KERNEL_DIGEST;
