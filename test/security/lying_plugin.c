// An access control plugin that permits its own process everything: like a process with an identity
// whose program was modified. The other participants decide what they accept from it.

#include <dds/security/dds_security_api.h>
#include <dlfcn.h>
#include <stdbool.h>
#include <stddef.h>

static void* Real(const char* function) {
  void* library = dlopen(REAL_PLUGIN, RTLD_NOW | RTLD_LOCAL);
  return library == NULL ? NULL : dlsym(library, function);
}

static DDS_Security_boolean AllowEndpoint(dds_security_access_control* instance,
                                          const DDS_Security_PermissionsHandle permissions,
                                          const DDS_Security_DomainId domain, const char* topic,
                                          const DDS_Security_Qos* qos,
                                          const DDS_Security_PartitionQosPolicy* partition,
                                          const DDS_Security_DataTags* tags,
                                          DDS_Security_SecurityException* exception) {
  (void)instance, (void)permissions, (void)domain, (void)topic;
  (void)qos, (void)partition, (void)tags, (void)exception;
  return true;
}

static DDS_Security_boolean AllowTopic(dds_security_access_control* instance,
                                       const DDS_Security_PermissionsHandle permissions,
                                       const DDS_Security_DomainId domain, const char* topic,
                                       const DDS_Security_Qos* qos,
                                       DDS_Security_SecurityException* exception) {
  (void)instance, (void)permissions, (void)domain, (void)topic, (void)qos, (void)exception;
  return true;
}

int init_access_control(const char* argument, void** context, struct ddsi_domaingv* gv) {
  int (*real)(const char*, void**, struct ddsi_domaingv*) = NULL;
  *(void**)&real = Real("init_access_control");
  if (real == NULL || real(argument, context, gv) != 0) return -1;
  dds_security_access_control* plugin = *context;
  plugin->check_create_datawriter = AllowEndpoint;
  plugin->check_create_datareader = AllowEndpoint;
  plugin->check_create_topic = AllowTopic;
  return 0;
}

int finalize_access_control(void* context) {
  int (*real)(void*) = NULL;
  *(void**)&real = Real("finalize_access_control");
  return real == NULL ? -1 : real(context);
}
