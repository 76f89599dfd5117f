// SPDX-License-Identifier: BSD-3-Clause
#define OSTEOMILL_WIDTH 8
#define OSTEOMILL_EXP Sleef_expd8_u10avx512f
#define OSTEOMILL_LOG Sleef_logd8_u35avx512f
#define OSTEOMILL_NAME "avx512"
#define OSTEOMILL_FUNCTIONS kAvx512
#include "osteomill/cutting/component_kernel.inc"
