// SPDX-License-Identifier: BSD-3-Clause
#define OSTEOMILL_ARCH xsimd::sse2
#define OSTEOMILL_NAME evaluate_sse2
#include "osteomill/cutting/component_kernel.inc"
