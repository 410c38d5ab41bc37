/* A plugin of the emulator QEMU that counts the instructions of every step of a node: those executed
 * between the functions mrroc_step_begins and mrroc_step_ends, by their addresses. One number a line.
 * Without an end, those from the entry of a function to its return. What is executed between a pause and a resume,
 * of an interrupt, is not counted.
 *
 *   cc -O2 -fPIC -shared -o steps.so steps.c
 *   qemu-system-arm … -plugin steps.so,begin=0x1234,end=0x5678,out=counts
 *
 * Instructions are counted by translated blocks: a call begins a block of its own, so both functions do.
 * The few declarations of QEMU's plugin interface (its version 1, of 2019) stand here, so that no header
 * is needed. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef uint64_t plugin_id;
struct qemu_plugin_tb;
typedef void (*translated)(plugin_id, struct qemu_plugin_tb *);
typedef void (*executed)(unsigned int, void *);
typedef void (*ended)(plugin_id, void *);
void qemu_plugin_register_vcpu_tb_trans_cb(plugin_id, translated);
void qemu_plugin_register_vcpu_tb_exec_cb(struct qemu_plugin_tb *, executed, int flags, void *);
void qemu_plugin_register_atexit_cb(plugin_id, ended, void *);
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb *);
uint64_t qemu_plugin_tb_vaddr(const struct qemu_plugin_tb *);
struct qemu_plugin_insn;
struct qemu_plugin_insn *qemu_plugin_tb_get_insn(const struct qemu_plugin_tb *, size_t);
uint64_t qemu_plugin_insn_vaddr(const struct qemu_plugin_insn *);
size_t qemu_plugin_insn_size(const struct qemu_plugin_insn *);

__attribute__((visibility("default"))) int qemu_plugin_version = 1;

struct block {
    uint64_t address;
    /* the one behind it, where a call at its end returns to */
    uint64_t next;
    uint64_t instructions;
};

static uint64_t begin_address, end_address, pause_address, resume_address, begun_at, paused_at, total;
static uint64_t behind_last_block, returns_to;
static int inside;
static FILE *out;

static void on_block(unsigned int cpu, void *data)
{
    const struct block *block = data;
    (void)cpu;
    if (inside && block->address == (end_address ? end_address : returns_to)) {
        fprintf(out, "%" PRIu64 "\n", total - begun_at);
        inside = 0;
    }
    if (pause_address && block->address == pause_address)
        paused_at = total;
    total += block->instructions;
    if (resume_address && block->address == resume_address)
        begun_at += total - paused_at;
    if (block->address == begin_address && !inside) {
        /* of a function, its own first block counts; a mark is none of what it marks */
        begun_at = end_address ? total : total - block->instructions;
        returns_to = behind_last_block;
        inside = 1;
    }
    behind_last_block = block->next;
}

static void on_translation(plugin_id id, struct qemu_plugin_tb *tb)
{
    /* blocks live as long as the emulator: it may translate the same one again */
    struct block *block = malloc(sizeof *block);
    (void)id;
    if (!block)
        abort();
    block->address = qemu_plugin_tb_vaddr(tb);
    block->instructions = qemu_plugin_tb_n_insns(tb);
    const struct qemu_plugin_insn *last = qemu_plugin_tb_get_insn(tb, block->instructions - 1);
    block->next = qemu_plugin_insn_vaddr(last) + qemu_plugin_insn_size(last);
    qemu_plugin_register_vcpu_tb_exec_cb(tb, on_block, 0, block);
}

static void on_end(plugin_id id, void *data)
{
    (void)id;
    (void)data;
    fclose(out);
}

__attribute__((visibility("default"))) int qemu_plugin_install(plugin_id id, const void *info, int argc,
                                                               char **argv)
{
    (void)info;
    for (int i = 0; i < argc; i++) {
        if (!strncmp(argv[i], "begin=", 6))
            begin_address = strtoull(argv[i] + 6, NULL, 0);
        else if (!strncmp(argv[i], "end=", 4))
            end_address = strtoull(argv[i] + 4, NULL, 0);
        else if (!strncmp(argv[i], "pause=", 6))
            pause_address = strtoull(argv[i] + 6, NULL, 0);
        else if (!strncmp(argv[i], "resume=", 7))
            resume_address = strtoull(argv[i] + 7, NULL, 0);
        else if (!strncmp(argv[i], "out=", 4))
            out = fopen(argv[i] + 4, "w");
        else
            return 1;
    }
    if (!out || !begin_address)
        return 1;
    qemu_plugin_register_vcpu_tb_trans_cb(id, on_translation);
    qemu_plugin_register_atexit_cb(id, on_end, NULL);
    return 0;
}
