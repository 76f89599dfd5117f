// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/report_page.hpp"

// The assembler puts the file into the program as it is: no generated source, no time to compile.
asm(".section .rodata\n"
    "osteomill_report_page_begin:\n"
    ".incbin \"" OSTEOMILL_REPORT_PAGE
    "\"\n"
    "osteomill_report_page_end:\n"
    ".byte 0\n"
    ".previous\n"
    ".global osteomill_report_page_begin, osteomill_report_page_end\n");

extern "C" {
extern const char osteomill_report_page_begin[];
extern const char osteomill_report_page_end[];
}

namespace osteomill::io {

std::string_view report_page() { return {osteomill_report_page_begin, osteomill_report_page_end}; }

}  // namespace osteomill::io
