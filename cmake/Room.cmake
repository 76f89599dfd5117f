# A room is one folder, one namespace, one library target, one test program.
#
#   osteomill_room(cutting USES base bone [LINKS Eigen3::Eigen] [PRIVATE_LINKS TBB::tbb])
#
# Sources are all *.cpp of the folder; *_test.cpp go to the room's test program. USES names rooms,
# and tools/check_layers.py checks the includes against layers.txt.

add_library(osteomill_warnings INTERFACE)
target_compile_options(osteomill_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
  -Wnon-virtual-dtor -Woverloaded-virtual -Werror)

find_package(GTest REQUIRED)
include(GoogleTest)

function(osteomill_tests name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  add_executable(osteomill_${name}_test ${ARG_SOURCES})
  target_link_libraries(osteomill_${name}_test PRIVATE ${ARG_LINKS} osteomill_warnings
    GTest::gmock GTest::gtest_main)
  target_compile_definitions(osteomill_${name}_test PRIVATE
    OSTEOMILL_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
  gtest_discover_tests(osteomill_${name}_test TEST_PREFIX ${name}. DISCOVERY_MODE PRE_TEST
    DISCOVERY_TIMEOUT 60 NO_PRETTY_VALUES)
endfunction()

function(osteomill_room name)
  cmake_parse_arguments(ROOM "" "" "USES;LINKS;PRIVATE_LINKS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  set(tests ${sources})
  list(FILTER sources EXCLUDE REGEX "_test\\.cpp$")
  list(FILTER tests INCLUDE REGEX "_test\\.cpp$")
  list(TRANSFORM ROOM_USES PREPEND osteomill::)
  if(sources)
    add_library(osteomill_${name} STATIC ${sources})
    target_include_directories(osteomill_${name} PUBLIC ${CMAKE_SOURCE_DIR}/src)
    target_link_libraries(osteomill_${name} PUBLIC ${ROOM_USES} ${ROOM_LINKS}
      PRIVATE osteomill_warnings ${ROOM_PRIVATE_LINKS})
  else()
    add_library(osteomill_${name} INTERFACE)
    target_include_directories(osteomill_${name} INTERFACE ${CMAKE_SOURCE_DIR}/src)
    target_link_libraries(osteomill_${name} INTERFACE ${ROOM_USES} ${ROOM_LINKS})
  endif()
  add_library(osteomill::${name} ALIAS osteomill_${name})
  if(tests)
    osteomill_tests(${name} SOURCES ${tests} LINKS osteomill::${name} ${ROOM_PRIVATE_LINKS})
  endif()
endfunction()
