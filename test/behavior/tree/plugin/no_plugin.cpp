// A shared library that has no nodes.

extern "C" __attribute__((visibility("default"))) int no_plugin_at_all() {
  return 0;
}
