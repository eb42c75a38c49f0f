# Gives each suite of a GoogleTest program to ctest as one test: run by musher_test() after the program is
# linked, with PROGRAM, OUTPUT (the file to write), PROPERTIES (of the tests).
execute_process(COMMAND ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE listed RESULT_VARIABLE status
                TIMEOUT 60)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "${PROGRAM} --gtest_list_tests failed: ${status}")
endif()
string(REGEX MATCHALL "(^|\n)[^ \n][^\n]*\\.( *#[^\n]*)?" suites "${listed}")  # tests are indented
set(script)
foreach(suite ${suites})
  string(REGEX MATCH "[^ \n#]+\\." suite "${suite}")
  string(REGEX REPLACE "\\.$" "" name "${suite}")
  string(APPEND script "add_test([==[${name}]==] [==[${PROGRAM}]==] [==[--gtest_filter=${name}.*]==])\n"
         "set_tests_properties([==[${name}]==] PROPERTIES ${PROPERTIES})\n")
endforeach()
file(WRITE ${OUTPUT} "${script}")
