// A plugin of qemu-user (API version 1: QEMU 4.2 to 8): executed instructions, in all and per function.
//   qemu-aarch64 -plugin libcount_instructions_plugin.so,out=FILE PROGRAM
// FILE gets a line a function, "COUNT NAME"; what has no name (shared libraries) stands under "?".
// Debian packages no qemu-plugin.h, so the declarations in use stand here.
#include <inttypes.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef uint64_t qemu_plugin_id_t;
typedef struct qemu_info qemu_info_t;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
enum qemu_plugin_op { QEMU_PLUGIN_INLINE_ADD_U64 };
void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t id,
                                           void (*callback)(qemu_plugin_id_t, struct qemu_plugin_tb*));
void qemu_plugin_register_atexit_cb(qemu_plugin_id_t id, void (*callback)(qemu_plugin_id_t, void*),
                                    void* data);
void qemu_plugin_register_vcpu_insn_exec_inline(struct qemu_plugin_insn* insn, enum qemu_plugin_op op,
                                                void* counter, uint64_t amount);
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb* tb);
struct qemu_plugin_insn* qemu_plugin_tb_get_insn(const struct qemu_plugin_tb* tb, size_t index);
const char* qemu_plugin_insn_symbol(const struct qemu_plugin_insn* insn);

#define EGOFOCUS_PLUGIN __attribute__((visibility("default")))
EGOFOCUS_PLUGIN int qemu_plugin_version = 1;
EGOFOCUS_PLUGIN int qemu_plugin_install(qemu_plugin_id_t id, const qemu_info_t* info, int argc, char** argv);

struct function {
  char* name;
  uint64_t count;
};
enum { kFunctions = 1 << 16 };  // a power of two, beyond any program's here
static struct function functions[kFunctions];
static const char* path;

static uint64_t* counter_of(const char* name) {
  uint32_t hash = 2166136261u;
  for (const char* c = name; *c != 0; ++c) hash = (hash ^ (unsigned char)*c) * 16777619u;
  for (int tries = 0; tries < kFunctions; ++tries, ++hash) {
    struct function* function = &functions[hash % kFunctions];
    if (function->name == NULL) function->name = strdup(name);
    if (strcmp(function->name, name) == 0) return &function->count;
  }
  abort();
}

static void on_translation(qemu_plugin_id_t id, struct qemu_plugin_tb* tb) {
  (void)id;
  const size_t count = qemu_plugin_tb_n_insns(tb);
  for (size_t i = 0; i < count; ++i) {
    struct qemu_plugin_insn* insn = qemu_plugin_tb_get_insn(tb, i);
    const char* name = qemu_plugin_insn_symbol(insn);
    uint64_t* counter = counter_of(name != NULL && *name != 0 ? name : "?");
    qemu_plugin_register_vcpu_insn_exec_inline(insn, QEMU_PLUGIN_INLINE_ADD_U64, counter, 1);
  }
}

static void on_exit_of_program(qemu_plugin_id_t id, void* data) {
  (void)id, (void)data;
  FILE* file = fopen(path, "w");
  if (file == NULL) {
    perror(path);
    return;
  }
  for (int i = 0; i < kFunctions; ++i) {
    if (functions[i].count != 0) fprintf(file, "%" PRIu64 " %s\n", functions[i].count, functions[i].name);
  }
  fclose(file);
}

int qemu_plugin_install(qemu_plugin_id_t id, const qemu_info_t* info, int argc, char** argv) {
  (void)info;
  if (argc != 1 || strncmp(argv[0], "out=", 4) != 0) {
    fprintf(stderr, "count_instructions_plugin: out=FILE is missing\n");
    return 1;
  }
  path = strdup(argv[0] + 4);
  qemu_plugin_register_vcpu_tb_trans_cb(id, on_translation);
  qemu_plugin_register_atexit_cb(id, on_exit_of_program, NULL);
  return 0;
}
