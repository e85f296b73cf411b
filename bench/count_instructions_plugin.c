// A plugin of qemu-user (API version 1: QEMU 4.2 to 8): executed instructions, in all and per function.
//   qemu-aarch64 -plugin libcount_instructions_plugin.so,out=FILE PROGRAM
// FILE gets a line a function, "COUNT NAME"; what has no name (shared libraries) stands under "?". With
// ",threads=on" a line a function and thread, "COUNT THREAD NAME", thread 0 being the first: whole blocks, by
// the name that each begins with. Debian packages no qemu-plugin.h, so the declarations in use stand here.
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
enum qemu_plugin_cb_flags { QEMU_PLUGIN_CB_NO_REGS };
void qemu_plugin_register_vcpu_tb_exec_cb(struct qemu_plugin_tb* tb, void (*callback)(unsigned int, void*),
                                          enum qemu_plugin_cb_flags flags, void* data);
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

enum { kThreads = 8, kFunctions = 1 << 16 };  // a power of two, beyond any program's here
struct function {
  char* name;
  uint64_t count[kThreads];
};
static struct function functions[kFunctions];
static const char* path;
static int by_thread;

static uint64_t* counter_of(const char* name) {
  uint32_t hash = 2166136261u;
  for (const char* c = name; *c != 0; ++c) hash = (hash ^ (unsigned char)*c) * 16777619u;
  for (int tries = 0; tries < kFunctions; ++tries, ++hash) {
    struct function* function = &functions[hash % kFunctions];
    if (function->name == NULL) function->name = strdup(name);
    if (strcmp(function->name, name) == 0) return function->count;
  }
  abort();
}

// A block on its way to be run.
struct block {
  uint64_t* counts;
  size_t instructions;
};

static void on_block(unsigned int thread, void* data) {
  const struct block* block = data;
  if (thread < kThreads) block->counts[thread] += block->instructions;
}

static const char* name_of(const struct qemu_plugin_insn* insn) {
  const char* name = qemu_plugin_insn_symbol(insn);
  return name != NULL && *name != 0 ? name : "?";
}

static void on_translation(qemu_plugin_id_t id, struct qemu_plugin_tb* tb) {
  (void)id;
  const size_t count = qemu_plugin_tb_n_insns(tb);
  if (by_thread) {
    struct block* block = malloc(sizeof *block);  // lives as long as the program
    if (block == NULL) abort();
    block->counts = counter_of(name_of(qemu_plugin_tb_get_insn(tb, 0)));
    block->instructions = count;
    qemu_plugin_register_vcpu_tb_exec_cb(tb, on_block, QEMU_PLUGIN_CB_NO_REGS, block);
    return;
  }
  for (size_t i = 0; i < count; ++i) {
    struct qemu_plugin_insn* insn = qemu_plugin_tb_get_insn(tb, i);
    uint64_t* counter = counter_of(name_of(insn));
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
    for (int thread = 0; thread < kThreads; ++thread) {
      const uint64_t count = functions[i].count[thread];
      if (count != 0 && by_thread) fprintf(file, "%" PRIu64 " %d %s\n", count, thread, functions[i].name);
      if (count != 0 && !by_thread) fprintf(file, "%" PRIu64 " %s\n", count, functions[i].name);
    }
  }
  fclose(file);
}

int qemu_plugin_install(qemu_plugin_id_t id, const qemu_info_t* info, int argc, char** argv) {
  (void)info;
  by_thread = argc == 2 && strcmp(argv[1], "threads=on") == 0;
  if (argc != 1 + by_thread || strncmp(argv[0], "out=", 4) != 0) {
    fprintf(stderr, "count_instructions_plugin: out=FILE is missing\n");
    return 1;
  }
  path = strdup(argv[0] + 4);
  qemu_plugin_register_vcpu_tb_trans_cb(id, on_translation);
  qemu_plugin_register_atexit_cb(id, on_exit_of_program, NULL);
  return 0;
}
