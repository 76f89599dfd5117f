// SPDX-License-Identifier: BSD-3-Clause
#define OSTEOMILL_WIDTH 4
#define OSTEOMILL_NAME "avx2"
#define OSTEOMILL_FUNCTIONS kAvx2
#include "osteomill/workpiece/layer_kernel.inc"
