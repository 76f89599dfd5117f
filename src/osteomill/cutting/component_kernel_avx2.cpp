// SPDX-License-Identifier: BSD-3-Clause
#define OSTEOMILL_WIDTH 4
#define OSTEOMILL_EXP Sleef_expd4_u10avx2
#define OSTEOMILL_LOG Sleef_logd4_u35avx2
#define OSTEOMILL_NAME "avx2"
#define OSTEOMILL_FUNCTIONS kAvx2
#include "osteomill/cutting/component_kernel.inc"
