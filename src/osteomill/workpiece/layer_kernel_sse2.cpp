// SPDX-License-Identifier: BSD-3-Clause
#define OSTEOMILL_WIDTH 2
#define OSTEOMILL_NAME "sse2"
#define OSTEOMILL_FUNCTIONS kSse2
#include "osteomill/workpiece/layer_kernel.inc"
