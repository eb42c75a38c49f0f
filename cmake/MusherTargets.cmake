# How every library and program of Musher is built: one target a folder, an alias, the same warnings.

# Sources are included as "musher/<folder>/<file>.hpp", in this tree as in an installed one: include/musher has a
# link to each folder of sources, the build tree the headers of messages/, which are generated.
set(MUSHER_GENERATED_DIR ${PROJECT_BINARY_DIR}/include)
set(MUSHER_INCLUDE_DIR ${PROJECT_SOURCE_DIR}/include ${MUSHER_GENERATED_DIR})

find_program(CCACHE ccache)
if(CCACHE)
  set(CMAKE_C_COMPILER_LAUNCHER ${CCACHE})
  # Without the first ccache does not cache sources that use precompiled headers; with the second it reads
  # their checksum (test/CMakeLists.txt), not their 120 MB, for each source.
  set(CMAKE_CXX_COMPILER_LAUNCHER
    ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros CCACHE_PCH_EXTSUM=1 ${CCACHE})
endif()

# Some 180 programs are linked, each in a fraction of the time.
include(CheckLinkerFlag)
find_program(MOLD mold)
if(MOLD AND PROJECT_IS_TOP_LEVEL)
  check_linker_flag(CXX -fuse-ld=mold MUSHER_HAS_MOLD)
  if(MUSHER_HAS_MOLD)
    add_link_options(-fuse-ld=mold)
  endif()
endif()

# What runs the programs of another architecture; empty where they run as they are.
set(MUSHER_EMULATOR "")
if(CMAKE_CROSSCOMPILING)
  set(MUSHER_EMULATOR ${CMAKE_CROSSCOMPILING_EMULATOR})
endif()

# musher_target(<target>) sets what all targets have in common: the warnings, and a unity build of
# MUSHER_UNITY_BATCH sources at a time, which halves the time because shared headers are read once. In a
# unity build the names in the anonymous namespaces of a target must differ, and each test has a namespace of
# its own name.
#
# -Wno-restrict, -Wno-maybe-uninitialized: false alarms of GCC 12 when it optimises strings and variants
# (its bugs 105651 and 105562). -Wno-subobject-linkage: GCC warns of a class with a member of a type in
# an anonymous namespace unless both are in the main file, which in a unity build they are not.
#
# -ffp-contract=off: ARM has instructions that multiply and add without rounding in between, which GCC uses where it
# can. What a robot has recorded is decided again on a laptop, number for number. x86-64 has them with -march only.
#
# The parameters of GCC: where there is memory for each CPU it collects garbage a few times less, which is 12 % of the
# time of a build and takes up to 3.5 GB a compiler; elsewhere more often, which takes 2 GB and a fifth more time.
cmake_host_system_information(RESULT musher_cpus QUERY NUMBER_OF_LOGICAL_CORES)
math(EXPR musher_mb_per_cpu "${MUSHER_MEMORY_MB} / ${musher_cpus}")
if(musher_mb_per_cpu GREATER 3500)
  set(MUSHER_GARBAGE_COLLECTION "--param ggc-min-expand=200 --param ggc-min-heapsize=1048576")
else()
  set(MUSHER_GARBAGE_COLLECTION "--param ggc-min-expand=30 --param ggc-min-heapsize=131072")
endif()
include(MusherUnity)
include(MusherPrecompiled)
function(musher_target target)
  target_compile_options(${target} PRIVATE
    -Wall -Wextra -Wpedantic -Wconversion -Wno-sign-conversion -fmacro-prefix-map=${PROJECT_SOURCE_DIR}/=
    $<$<NOT:$<STREQUAL:${CMAKE_SYSTEM_PROCESSOR},x86_64>>:-ffp-contract=off>
    $<$<COMPILE_LANGUAGE:CXX>:-Wnon-virtual-dtor -Woverloaded-virtual>
    "$<$<COMPILE_LANG_AND_ID:CXX,GNU>:SHELL:${MUSHER_GARBAGE_COLLECTION}>"
    $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wshadow=local -Wno-restrict -Wno-maybe-uninitialized>
    $<$<AND:$<BOOL:${MUSHER_UNITY}>,$<COMPILE_LANG_AND_ID:CXX,GNU>>:-Wno-subobject-linkage>
    $<$<BOOL:${MUSHER_WERROR}>:-Werror>)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${MUSHER_UNITY}
    UNITY_BUILD_BATCH_SIZE ${MUSHER_UNITY_BATCH})
  cmake_language(EVAL CODE "cmake_language(DEFER CALL musher_join_sources [[${target}]])")  # all its sources are known
  musher_precompile(${target})
  add_dependencies(${target} musher_message_headers)
endfunction()

set(MUSHER_COMPUTING_FLAGS "" CACHE STRING "Compiler flags of the libraries that compute most")
# musher_computes(<target>...): tests and demos wait for these; the others wait for messages, and compile in two
# thirds of the time with -Og.
function(musher_computes)
  separate_arguments(flags NATIVE_COMMAND "${MUSHER_COMPUTING_FLAGS}")
  foreach(target ${ARGN})
    target_compile_options(${target} PRIVATE ${flags})
  endforeach()
endfunction()

# Shared libraries. Before 1.0 a MINOR may change what is inlined into a program, so the file and each symbol have the
# version of MAJOR.MINOR: a program of another one does not start, and a process may have both. There is no namespace
# of the version in C++: nothing but the libraries would have it, and every message of the compiler.
if(MUSHER_SHARED)
  set(MUSHER_ABI ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  set(MUSHER_SYMBOLS ${PROJECT_BINARY_DIR}/musher_symbols.map)
  file(CONFIGURE OUTPUT ${MUSHER_SYMBOLS} CONTENT "MUSHER_@MUSHER_ABI@ { global: *; };\n" @ONLY)
  # An installed program and library find the libraries wherever the installation is.
  file(RELATIVE_PATH libraries ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
  set(CMAKE_INSTALL_RPATH "$ORIGIN/${libraries}" "$ORIGIN")
endif()
function(musher_share target)
  # Without a definition for each library, which would change the command line of the compiler.
  set_target_properties(${target} PROPERTIES VERSION ${PROJECT_VERSION} SOVERSION ${MUSHER_ABI} DEFINE_SYMBOL ""
    LINK_DEPENDS ${MUSHER_SYMBOLS})
  target_link_options(${target} PRIVATE LINKER:--version-script=${MUSHER_SYMBOLS})
  if(NOT CMAKE_CXX_FLAGS MATCHES "-fsanitize")
    target_link_options(${target} PRIVATE LINKER:--no-undefined)
  endif()
endfunction()

# musher_library(<name> SOURCES <cpp>... DEPENDS <public target>... PRIVATE <private target>...)
# makes musher_<name> with the alias musher::<name>, installed and exported.
function(musher_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS;PRIVATE" ${ARGN})
  set(target musher_${name})
  if(ARG_SOURCES)
    if(MUSHER_SHARED)
      add_library(${target} SHARED ${ARG_SOURCES})
      musher_share(${target})
    else()
      add_library(${target} STATIC ${ARG_SOURCES})
    endif()
    set(scope PUBLIC)
    musher_target(${target})
    target_link_libraries(${target} PRIVATE ${ARG_PRIVATE})
  else()
    add_library(${target} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(musher::${name} ALIAS ${target})
  target_compile_features(${target} ${scope} cxx_std_20)
  target_include_directories(${target} ${scope}
    "$<BUILD_INTERFACE:${MUSHER_INCLUDE_DIR}>" $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(${target} ${scope} ${ARG_DEPENDS})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  set_property(GLOBAL APPEND PROPERTY MUSHER_INSTALLED_TARGETS ${target})
endfunction()

# musher_program(<name> SOURCES <cpp>... DEPENDS <target>...) makes an installed program. The target
# programs makes all of them.
add_custom_target(programs)
function(musher_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  musher_target(${name})
  target_link_libraries(${name} PRIVATE ${ARG_DEPENDS})
  add_dependencies(programs ${name})
  install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  if(PROJECT_IS_TOP_LEVEL AND (NOT CMAKE_CROSSCOMPILING OR CMAKE_CROSSCOMPILING_EMULATOR))
    musher_man_page(${name})
  endif()
  if(MUSHER_TESTS)
    add_test(NAME ${name}.PrintsTheVersion COMMAND ${name} --version)
    set_tests_properties(${name}.PrintsTheVersion PROPERTIES
      PASS_REGULAR_EXPRESSION "^${name} ${PROJECT_VERSION}\n$" TIMEOUT 60 LABELS version)
  endif()
endfunction()

# The manual page of a program, from its help.
if(PROJECT_IS_TOP_LEVEL)
  add_custom_target(man_pages ALL)
endif()
function(musher_man_page name)
  set(generator ${PROJECT_SOURCE_DIR}/cmake/packages/man_page.py)
  set(page ${PROJECT_BINARY_DIR}/share/man/${name}.1)
  add_custom_command(OUTPUT ${page} DEPENDS ${name} ${generator} VERBATIM
    COMMAND ${Python3_EXECUTABLE} ${generator} $<TARGET_FILE:${name}> ${page} ${MUSHER_EMULATOR})
  add_custom_target(${name}_man_page DEPENDS ${page})
  add_dependencies(man_pages ${name}_man_page)
  install(FILES ${page} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
endfunction()

# musher_test(<name> SOURCES <cpp>... DEPENDS <target>... [LABELS ...] [TIMEOUT s] [COST s] [ALONE regex] [EACH] [COMPUTES]
# [NIGHTLY] [NIGHTLY_TESTS regex]) makes a
# GoogleTest program and gives its suites to ctest, which starts those of high cost first. A start takes 0.05
# to 0.5 s of a CPU and most tests take less: a process for each test doubled the time of all. ALONE: only the suites
# whose names match have a process each, and the others, which leave nothing behind, one for all; OpenCV's programs
# need 0.3 s to start. EACH: one for
# each test, of suites with tests of many seconds, which can run beside each other. COMPUTES: they use a CPU and
# hundreds of MB all the time, where other tests wait; ctest runs few of them at a time. NIGHTLY: only
# MUSHER_NIGHTLY builds the program with `all` and gives its tests to ctest; NIGHTLY_TESTS: only the tests
# (without EACH, suites) whose names match.
function(musher_test name)
  cmake_parse_arguments(ARG "EACH;COMPUTES;NIGHTLY" "TIMEOUT;COST;ALONE;NIGHTLY_TESTS" "SOURCES;DEPENDS;LABELS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  musher_target(${name})
  target_include_directories(${name} PRIVATE ${MUSHER_INCLUDE_DIR})
  target_link_libraries(${name} PRIVATE ${ARG_DEPENDS} musher_test_support GTest::gmock_main)
  if(MUSHER_TEST_HEADERS)  # none where they are compiled with other flags (musher_optimise_this_folder)
    musher_reuse_headers(${name} ${MUSHER_TEST_HEADERS})
  endif()
  if(ARG_NIGHTLY AND NOT MUSHER_NIGHTLY)
    set_target_properties(${name} PROPERTIES EXCLUDE_FROM_ALL TRUE)
    return()
  endif()
  if(MUSHER_NIGHTLY OR NOT ARG_NIGHTLY_TESTS)
    set(ARG_NIGHTLY_TESTS "^$")
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 900)  # far beyond need: a busy computer is no failure
    if(MUSHER_NIGHTLY)  # more cases, and perhaps beside a build
      set(ARG_TIMEOUT 1800)
    endif()
  endif()
  if(NOT ARG_COST)
    set(ARG_COST 0)
  endif()
  set(tests ${CMAKE_CURRENT_BINARY_DIR}/${name}_tests.cmake)
  add_custom_command(TARGET ${name} POST_BUILD VERBATIM BYPRODUCTS ${tests}
    COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:${name}> "-DEMULATOR=${MUSHER_EMULATOR}" -DOUTPUT=${tests} -DEACH=${ARG_EACH} "-DALONE=${ARG_ALONE}"
            -DNIGHTLY=${MUSHER_NIGHTLY} -DCOMPUTES=${ARG_COMPUTES}
            -DTIMEOUT=${ARG_TIMEOUT} -DCOST=${ARG_COST} "-DLABELS=${ARG_LABELS}"
            "-DLEFT_OUT=${ARG_NIGHTLY_TESTS}"
            -P ${PROJECT_SOURCE_DIR}/cmake/DiscoverTests.cmake)
  # A build of some targets only has no such file of the others.
  set(include ${CMAKE_CURRENT_BINARY_DIR}/${name}_include.cmake)
  file(CONFIGURE OUTPUT ${include} @ONLY CONTENT
    "if(EXISTS [==[@tests@]==])\n  include([==[@tests@]==])\nelse()\n  add_test(@name@_NOT_BUILT @name@_NOT_BUILT)\nendif()\n")
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${include})
endfunction()
