# Read by cpack before it packs.
if(NOT EXISTS ${CPACK_MUSHER_SITE})
  list(REMOVE_ITEM CPACK_COMPONENTS_ALL doc)
endif()
