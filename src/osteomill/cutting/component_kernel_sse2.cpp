// SPDX-License-Identifier: BSD-3-Clause
#define OSTEOMILL_WIDTH 2
#define OSTEOMILL_EXP Sleef_expd2_u10sse2
#define OSTEOMILL_LOG Sleef_logd2_u35sse2
#define OSTEOMILL_NAME "sse2"
#define OSTEOMILL_FUNCTIONS kSse2
#include "osteomill/cutting/component_kernel.inc"
