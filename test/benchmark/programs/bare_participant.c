/* What a process on Cyclone costs at the least: one participant, nothing else.
 *
 *   benchmark_bare_participant DOMAIN
 */
#include <dds/dds.h>
#include <stdlib.h>
#include <unistd.h>

int main(int argc, char** argv) {
  if (argc < 2 || dds_create_participant((dds_domainid_t)atoi(argv[1]), NULL, NULL) < 0) return 1;
  for (;;) pause();
}
