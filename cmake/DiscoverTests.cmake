# Gives the suites of a GoogleTest program to ctest, each as one test; with EACH, the tests in them. Run by
# musher_test() after the program is linked, with PROGRAM, OUTPUT (the file to write), and the properties of
# the tests: TIMEOUT (s), COST, LABELS. Those whose names match LEFT_OUT are not given.
execute_process(COMMAND ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE listed RESULT_VARIABLE status
                TIMEOUT 60)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "${PROGRAM} --gtest_list_tests failed: ${status}")
endif()
set(script)
function(give_to_ctest name filter)
  if(name MATCHES "${LEFT_OUT}")
    return()
  endif()
  string(APPEND script "add_test([==[${name}]==] [==[${PROGRAM}]==] [==[--gtest_filter=${filter}]==])\n"
         "set_tests_properties([==[${name}]==] PROPERTIES TIMEOUT ${TIMEOUT} COST ${COST} LABELS [==[${LABELS}]==])\n")
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
      give_to_ctest("${name}" "${suite}*")
    endif()
  elseif(EACH AND line MATCHES "^\n  ")  # not "Running main() …"
    give_to_ctest("${suite}${name}" "${suite}${name}")
  endif()
endforeach()
file(WRITE ${OUTPUT} "${script}")
