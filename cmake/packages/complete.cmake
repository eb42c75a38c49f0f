# Run by cpack on the tree of each package before it is packed: what Debian's policy asks of every package.
set(tools ${CMAKE_CURRENT_LIST_DIR})
string(TIMESTAMP now "%a, %d %b %Y %H:%M:%S +0000" UTC)
foreach(component ${CPACK_COMPONENTS_ALL})
  string(TOUPPER ${component} upper)
  set(package ${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
  set(root ${CPACK_TEMPORARY_DIRECTORY}/${component})
  set(doc ${root}/usr/share/doc/${package})
  configure_file(${tools}/copyright ${doc}/copyright COPYONLY)
  configure_file(${tools}/changelog.in ${doc}/changelog.Debian @ONLY)
  configure_file(${tools}/../../CHANGELOG.md ${doc}/changelog COPYONLY)

  if(IS_DIRECTORY ${root}/usr/share/zsh/site-functions)  # Debian's zsh searches another folder
    file(RENAME ${root}/usr/share/zsh/site-functions ${root}/usr/share/zsh/vendor-completions)
  endif()
  file(GLOB libraries ${root}/usr/lib/*.a ${root}/usr/lib/*/*.a)
  foreach(library ${libraries})
    execute_process(COMMAND ${CPACK_MUSHER_STRIP} --strip-debug --enable-deterministic-archives
                            --remove-section=.comment --remove-section=.note ${library}
                    COMMAND_ERROR_IS_FATAL ANY)
  endforeach()
  file(GLOB pages ${root}/usr/share/man/man1/*.1)
  execute_process(COMMAND gzip -9nf ${pages} ${doc}/changelog ${doc}/changelog.Debian
                  COMMAND_ERROR_IS_FATAL ANY)
endforeach()
