# Gives the suites of a GoogleTest program to ctest, each as one test; with EACH, the tests in them; with ALONE, a
# regular expression, only the suites that match it, and the others as one test with the name of the program. Run by
# musher_test() after the program is linked, with PROGRAM, OUTPUT (the file to write), and the properties of the
# tests: TIMEOUT (s), COST, LABELS. Those whose names match LEFT_OUT are not given. NIGHTLY: the tests find
# MUSHER_NIGHTLY in their environment. Otherwise the properties of a program of some COST are tried with fewer cases.
execute_process(COMMAND ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE listed RESULT_VARIABLE status
                TIMEOUT 60)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "${PROGRAM} --gtest_list_tests failed: ${status}")
endif()
set(script)
set(together)
set(environment)
if(NIGHTLY)
  set(environment " ENVIRONMENT MUSHER_NIGHTLY=1")
elseif(COST GREATER 0)
  set(environment " ENVIRONMENT RC_PARAMS=max_success=12")  # RapidCheck's default is 100
endif()
function(give_to_ctest name filter)
  if(name MATCHES "${LEFT_OUT}")
    return()
  endif()
  string(APPEND script "add_test([==[${name}]==] [==[${PROGRAM}]==] [==[--gtest_filter=${filter}]==])\n"
         "set_tests_properties([==[${name}]==] PROPERTIES TIMEOUT ${TIMEOUT} COST ${COST} LABELS [==[${LABELS}]==]${environment})\n")
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
