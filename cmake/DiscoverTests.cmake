# Gives the suites of a GoogleTest program to ctest, each as one test; with EACH, the tests in them; with ALONE, a
# regular expression, only the suites that match it, and the others as one test with the name of the program. Run by
# musher_test() after the program is linked, with PROGRAM, OUTPUT (the file to write), and the properties of the
# tests: TIMEOUT (s), COST, LABELS. Those whose names match LEFT_OUT are not given. NIGHTLY: the tests find
# MUSHER_NIGHTLY in their environment; otherwise the properties of a program of some COST are tried with fewer cases.
# EMULATOR runs the program, if it is of another architecture. COMPUTES: each counts as four of the tests that ctest
# runs at a time, and its heap is in huge pages: a search of 600 MB took 65 s in a virtual machine whose neighbours
# were busy, and 8 s so.
execute_process(COMMAND ${EMULATOR} ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE listed RESULT_VARIABLE status
                TIMEOUT 60)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "${PROGRAM} --gtest_list_tests failed: ${status}")
endif()
set(script)
set(emulator)
if(EMULATOR)
  list(TRANSFORM EMULATOR REPLACE "(.+)" "[==[\\1]==] " OUTPUT_VARIABLE emulator)
  list(JOIN emulator "" emulator)
endif()
set(together)
set(variables)
if(NIGHTLY)
  list(APPEND variables MUSHER_NIGHTLY=1)
elseif(COST GREATER 0)
  list(APPEND variables RC_PARAMS=max_success=12)  # RapidCheck's default is 100
endif()
set(properties "TIMEOUT ${TIMEOUT} COST ${COST} LABELS [==[${LABELS}]==]")
if(COMPUTES)
  list(APPEND variables GLIBC_TUNABLES=glibc.malloc.hugetlb=1)
  string(APPEND properties " PROCESSORS 4")
endif()
if(variables)
  string(APPEND properties " ENVIRONMENT [==[${variables}]==]")
endif()
function(give_to_ctest name filter)
  if(name MATCHES "${LEFT_OUT}")
    return()
  endif()
  string(APPEND script "add_test([==[${name}]==] ${emulator}[==[${PROGRAM}]==] [==[--gtest_filter=${filter}]==])\n"
         "set_tests_properties([==[${name}]==] PROPERTIES ${properties})\n")
  set(script "${script}" PARENT_SCOPE)
endfunction()
string(REGEX REPLACE " *#[^\n]*" "" listed "${listed}")  # "Suite.  # TypeParam = …"
string(REGEX MATCHALL "(^|\n) *[A-Za-z0-9_/]+\\.?" lines "${listed}")
foreach(line ${lines})
  string(REGEX MATCH "[^ \n]+" name "${line}")
  if(name MATCHES "\\.$")
    set(suite "${name}")
    if(NOT EACH)
      string(REGEX REPLACE "\\.$" "" name "${suite}")
      if(NOT ALONE OR name MATCHES "${ALONE}")
        give_to_ctest("${name}" "${suite}*")
      elseif(NOT name MATCHES "${LEFT_OUT}")
        list(APPEND together "${suite}*")
      endif()
    endif()
  elseif(EACH AND line MATCHES "^\n  ")  # not "Running main() …"
    give_to_ctest("${suite}${name}" "${suite}${name}")
  endif()
endforeach()
if(together)
  get_filename_component(name ${PROGRAM} NAME)
  list(JOIN together ":" filter)
  give_to_ctest("${name}" "${filter}")
endif()
file(WRITE ${OUTPUT} "${script}")
