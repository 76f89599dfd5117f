// SPDX-License-Identifier: BSD-3-Clause
#define OSTEOMILL_WIDTH 8
#define OSTEOMILL_NAME "avx512"
#define OSTEOMILL_FUNCTIONS kAvx512
#include "osteomill/workpiece/layer_kernel.inc"
