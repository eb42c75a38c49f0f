# The target docs: the Markdown and the reference of the classes as a site, <build>/docs/html, which
# `cmake --install --component doc` puts into share/doc/musher/html. Not part of all; without Sphinx there is only
# a message that says what is missing.

set(MUSHER_SOURCE_URL "" CACHE STRING
    "Where the repository is read in a browser (https://host/owner/musher/blob/main), for links of the site")

find_program(SPHINX_BUILD sphinx-build)
find_program(DOXYGEN doxygen)
find_program(DOT dot)
if(NOT SPHINX_BUILD OR NOT DOXYGEN OR NOT DOT OR NOT Python3_Interpreter_FOUND)
  add_custom_target(docs
    COMMAND ${CMAKE_COMMAND} -E echo "sphinx-build, doxygen or dot is missing: scripts/bootstrap --docs, then cmake again"
    COMMAND ${CMAKE_COMMAND} -E false)
  return()
endif()

set(site ${PROJECT_SOURCE_DIR}/docs/site)
set(docs ${PROJECT_BINARY_DIR}/docs)
add_custom_target(docs
  COMMAND Python3::Interpreter -B ${site}/doc_comments.py ${PROJECT_SOURCE_DIR} ${docs}/headers
  COMMAND ${CMAKE_COMMAND} -E env MUSHER_DOXYGEN_INPUT=${docs}/headers MUSHER_DOXYGEN_OUTPUT=${docs}
          ${DOXYGEN} ${site}/Doxyfile
  COMMAND ${CMAKE_COMMAND} -E env PYTHONDONTWRITEBYTECODE=1 MUSHER_VERSION=${PROJECT_VERSION}
          MUSHER_DOXYGEN_XML=${docs}/xml MUSHER_SOURCE_URL=${MUSHER_SOURCE_URL}
          ${SPHINX_BUILD} -W --keep-going -q -j auto -b html -c ${site} -d ${docs}/doctrees
          ${PROJECT_SOURCE_DIR} ${docs}/html
  COMMAND Python3::Interpreter -B ${site}/check_site.py ${docs}/html
  COMMENT "Building the site of the documentation" USES_TERMINAL VERBATIM)

install(DIRECTORY ${docs}/html DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT doc OPTIONAL
        PATTERN ".buildinfo" EXCLUDE PATTERN "objects.inv" EXCLUDE PATTERN "_downloads" EXCLUDE)
