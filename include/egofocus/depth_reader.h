/* Depth frames of egofocusd, read from shared memory: one header, C11 or C++, Linux, nothing to link.
 *
 *   egofocus_depth_reader reader;
 *   int result = egofocus_depth_open(&reader, "/run/egofocus/depth.sock");
 *   while (result >= 0) {
 *     result = egofocus_depth_wait(&reader, 1000);
 *     if (result == 1 && egofocus_depth_newest(&reader, &info, inverse_depth, confidence) == 1) use(...);
 *   }
 *   egofocus_depth_close(&reader);
 *
 * Results are 1, 0 or a negative errno. The daemon never waits for a reader, and knows of one no more than
 * its connection: a reader may be late, slow, stopped or killed, and harms nobody. Nothing here allocates.
 * Thread: one per reader; readers are independent.
 *
 * --- layout, version 1 ------------------------------------------------------------------------------------
 * The daemon hands out a memory file, sealed against writing and shrinking, over a Unix socket
 * (SOCK_SEQPACKET): the first message carries the descriptor (SCM_RIGHTS), each later one of one byte says
 * "there is a new frame". Host byte order. egofocus_depth_header, then `slots` slots of `slot_bytes` each:
 *   byte 0      u32 lock: 2n when frame n lies in the slot whole, odd while it is written
 *   byte 64     egofocus_depth_info
 *   inverse_depth_at  u16 [height_px][width_px]
 *   confidence_at     u8  [height_px][width_px]
 * Frames are numbered from 1, modulo 2^32; frame n lies in slot n modulo slots. A reader takes `newest` (load
 * acquire), copies words between two looks at the slot's lock, and keeps the copy if both were 2n. */
#ifndef EGOFOCUS_DEPTH_READER_H
#define EGOFOCUS_DEPTH_READER_H

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#ifdef __cplusplus
extern "C" {
#endif

#define EGOFOCUS_DEPTH_MAGIC "EGODEPTH"
#define EGOFOCUS_DEPTH_LAYOUT 1u
#define EGOFOCUS_DEPTH_MAX_SLOTS 64u
#define EGOFOCUS_DEPTH_MAX_SIDE_PX 4096u
#define EGOFOCUS_DEPTH_INFO_AT 64u

typedef struct egofocus_depth_header { /* 128 bytes */
  char magic[8];                       /* EGOFOCUS_DEPTH_MAGIC, without its NUL */
  uint32_t layout;                     /* EGOFOCUS_DEPTH_LAYOUT */
  uint32_t header_bytes;               /* slot 0 begins here; a multiple of 64 */
  uint32_t slots;                      /* a power of two, 2..64 */
  uint32_t slot_bytes;                 /* a multiple of 64 */
  uint32_t width_px, height_px;        /* 1..4096 */
  uint32_t inverse_depth_at;           /* within a slot; multiples of 64 */
  uint32_t confidence_at;
  uint32_t unused[6];
  uint32_t newest; /* number of the newest whole frame; 0: none yet. Atomic; alone on its cache line */
  uint32_t unused_too[15];
} egofocus_depth_header;

/* All but the pixels, as in DepthFrame of types.hpp. Inverse depth of a pixel is
 * value * inverse_depth_scale_per_m in 1/m; with confidence 0 it is unknown, else the value 0 is infinity. */
typedef struct egofocus_depth_info { /* 192 bytes */
  int64_t t_us;                      /* what the frame is about: CLOCK_MONOTONIC; replayed under the virtual
                                        clock: the recording's time */
  int64_t age_us;                    /* t_us minus the time of the newest event that the depth rests on */
  int64_t latency_us;                /* from t_us to the end of the tick; virtual clock: 0 */
  int64_t window_begin_us;           /* events from here to t_us count */
  uint64_t sequence;                 /* tick number, from 0 */
  uint64_t votes;
  double inverse_depth_scale_per_m;
  double parallax_px;
  double velocity_m_s[3]; /* of the camera, in its frame: x right, y down, z forward */
  double angular_rate_rad_s[3];
  double velocity_sigma_m_s;
  double fx_px, fy_px, cx_px, cy_px; /* the grid that depth lies on */
  uint32_t flags; /* FrameFlag bits: 1 no parallax, 2 too few events, 4 stale velocity, 8 no motion, 16
                     overload, 32 late tick, 64 carried */
  uint32_t events;
  int32_t hypotheses;
  uint32_t width_px, height_px;
  uint32_t unused[5];
} egofocus_depth_info;

typedef struct egofocus_depth_reader {
  int socket;                  /* poll() it for POLLIN beside others, then call egofocus_depth_wait(r, 0) */
  const unsigned char* memory; /* ours, mapped read-only; NULL: not open */
  size_t bytes;
  egofocus_depth_header shape; /* checked once, at the beginning, and never read again */
  uint32_t last;               /* number of the frame that was read last; 0: none */
  uint64_t missed;             /* frames that were overwritten before egofocus_depth_next() came to them */
} egofocus_depth_reader;

/* Takes memory that is mapped already. 0; -EPROTO when it is not layout 1 or its sizes do not fit `bytes`.
 * `memory` lies at a multiple of 64. */
static inline int egofocus_depth_attach(egofocus_depth_reader* reader, const void* memory, size_t bytes) {
  egofocus_depth_header* h = &reader->shape;
  uint64_t pixels;
  memset(reader, 0, sizeof *reader);
  reader->socket = -1;
  if (bytes < sizeof *h) return -EPROTO;
  memcpy(h, memory, sizeof *h);
  if (memcmp(h->magic, EGOFOCUS_DEPTH_MAGIC, 8) != 0 || h->layout != EGOFOCUS_DEPTH_LAYOUT) return -EPROTO;
  if (h->slots < 2 || h->slots > EGOFOCUS_DEPTH_MAX_SLOTS || (h->slots & (h->slots - 1)) != 0) return -EPROTO;
  if (h->width_px < 1 || h->width_px > EGOFOCUS_DEPTH_MAX_SIDE_PX || h->height_px < 1 ||
      h->height_px > EGOFOCUS_DEPTH_MAX_SIDE_PX)
    return -EPROTO;
  if ((h->header_bytes | h->slot_bytes | h->inverse_depth_at | h->confidence_at) % 64 != 0) return -EPROTO;
  pixels = (uint64_t)h->width_px * h->height_px;
  if (h->header_bytes < sizeof *h ||
      h->inverse_depth_at < EGOFOCUS_DEPTH_INFO_AT + sizeof(egofocus_depth_info) ||
      h->inverse_depth_at + 2 * pixels > h->confidence_at || h->confidence_at + pixels > h->slot_bytes ||
      h->header_bytes + (uint64_t)h->slots * h->slot_bytes > bytes)
    return -EPROTO;
  reader->memory = (const unsigned char*)memory;
  reader->bytes = bytes;
  return 0;
}

static inline void egofocus_depth_close(egofocus_depth_reader* reader) {
  if (reader->memory != NULL && reader->socket >= 0) munmap((void*)(uintptr_t)reader->memory, reader->bytes);
  if (reader->socket >= 0) close(reader->socket);
  reader->memory = NULL;
  reader->socket = -1;
}

/* The descriptor that comes with the first message, or a negative errno. */
static inline int egofocus_depth_receive_(int socket) {
  char hello[64];
  union {
    struct cmsghdr align;
    char bytes[CMSG_SPACE(sizeof(int))];
  } control;
  struct iovec part;
  struct msghdr message;
  struct cmsghdr* carried;
  ssize_t got;
  int descriptor = -EPROTO;
  struct pollfd ready;
  ready.fd = socket;
  ready.events = POLLIN;
  ready.revents = 0;
  if (poll(&ready, 1, 5000) != 1) return -ETIMEDOUT;
  part.iov_base = hello;
  part.iov_len = sizeof hello;
  memset(&message, 0, sizeof message);
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.bytes;
  message.msg_controllen = sizeof control.bytes;
  got = recvmsg(socket, &message, MSG_CMSG_CLOEXEC | MSG_DONTWAIT);
  if (got < 0) return -errno;
  if (got == 0) return -EBUSY; /* the daemon has as many readers as it takes */
  carried = CMSG_FIRSTHDR(&message);
  if (carried != NULL && carried->cmsg_level == SOL_SOCKET && carried->cmsg_type == SCM_RIGHTS &&
      carried->cmsg_len == CMSG_LEN(sizeof(int)))
    memcpy(&descriptor, CMSG_DATA(carried), sizeof(int));
  return descriptor;
}

/* Connects and maps. 0; -ENOENT and -ECONNREFUSED: no daemon there; -EACCES: the socket's permissions;
 * -EBUSY: too many readers; -EPROTO: not a daemon of this layout. Waits at most 5 s. */
static inline int egofocus_depth_open(egofocus_depth_reader* reader, const char* socket_path) {
  struct sockaddr_un address;
  struct stat file;
  void* memory = MAP_FAILED;
  int result = 0, descriptor = -1, connection;
  memset(reader, 0, sizeof *reader);
  reader->socket = -1;
  memset(&address, 0, sizeof address);
  address.sun_family = AF_UNIX;
  if (strlen(socket_path) >= sizeof address.sun_path) return -ENAMETOOLONG;
  memcpy(address.sun_path, socket_path, strlen(socket_path));
  connection = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  if (connection < 0) return -errno;
  if (connect(connection, (const struct sockaddr*)&address, sizeof address) != 0) result = -errno;
  if (result == 0) {
    descriptor = egofocus_depth_receive_(connection);
    if (descriptor < 0) result = descriptor;
  }
  if (result == 0 && fstat(descriptor, &file) != 0) result = -errno;
  if (result == 0) {
    /* F_GET_SEALS with F_SEAL_SHRINK: without it the file could be cut off under our eyes (SIGBUS). */
    const int seals = fcntl(descriptor, 1034);
    if (seals < 0 || (seals & 0x0002) == 0 || file.st_size < (off_t)sizeof(egofocus_depth_header))
      result = -EPROTO;
  }
  if (result == 0) {
    memory = mmap(NULL, (size_t)file.st_size, PROT_READ, MAP_SHARED, descriptor, 0);
    if (memory == MAP_FAILED) result = -errno;
  }
  if (descriptor >= 0) close(descriptor);
  if (result == 0) result = egofocus_depth_attach(reader, memory, (size_t)file.st_size);
  if (result != 0) {
    if (memory != MAP_FAILED) munmap(memory, (size_t)file.st_size);
    close(connection);
    return result;
  }
  reader->socket = connection;
  return 0;
}

/* Number of elements that the arrays of a read need. */
static inline size_t egofocus_depth_pixels(const egofocus_depth_reader* reader) {
  return (size_t)reader->shape.width_px * reader->shape.height_px;
}

static inline uint32_t egofocus_depth_load_(const egofocus_depth_reader* reader, size_t at, int order) {
  const uint32_t* word = (const uint32_t*)(const void*)(reader->memory + at);
  return order == __ATOMIC_ACQUIRE ? __atomic_load_n(word, __ATOMIC_ACQUIRE)
                                   : __atomic_load_n(word, __ATOMIC_RELAXED);
}

static inline uint32_t egofocus_depth_newest_number_(const egofocus_depth_reader* reader) {
  return egofocus_depth_load_(reader, offsetof(egofocus_depth_header, newest), __ATOMIC_ACQUIRE);
}

/* 1: there is a frame newer than the last one read; 0: none within the time (it may come back early: call
 * again); -EPIPE: the daemon has ended or begun anew, open again (frames that are there can still be read).
 */
static inline int egofocus_depth_wait(egofocus_depth_reader* reader, int timeout_ms) {
  int turn;
  for (turn = 0; turn < 2; ++turn) {
    char bytes[64];
    int gone = 0, messages;
    for (messages = 0; messages < 1024 && !gone; ++messages) {
      const ssize_t got = recv(reader->socket, bytes, sizeof bytes, MSG_DONTWAIT);
      if (got > 0) continue;
      if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) break;
      gone = 1;
    }
    if (egofocus_depth_newest_number_(reader) != reader->last) return 1;
    if (gone) return -EPIPE;
    if (turn == 0) {
      struct pollfd ready;
      ready.fd = reader->socket;
      ready.events = POLLIN;
      ready.revents = 0;
      if (poll(&ready, 1, timeout_ms) <= 0) return 0;
    }
  }
  return 0;
}

/* Word by word: what a writer does meanwhile gives a stale word, never an undefined one. */
static inline void egofocus_depth_copy_(const egofocus_depth_reader* reader, size_t at, void* to,
                                        size_t bytes) {
  size_t done;
  for (done = 0; done < bytes; done += 4) {
    const uint32_t word = egofocus_depth_load_(reader, at + done, __ATOMIC_RELAXED);
    memcpy((char*)to + done, &word, bytes - done < 4 ? bytes - done : 4);
  }
}

static inline int egofocus_depth_read_(egofocus_depth_reader* reader, int in_order, egofocus_depth_info* info,
                                       uint16_t* inverse_depth, uint8_t* confidence) {
  const egofocus_depth_header* h = &reader->shape;
  const size_t pixels = egofocus_depth_pixels(reader);
  int turn;
  for (turn = 0; turn < 16; ++turn) {
    const uint32_t newest = egofocus_depth_newest_number_(reader);
    const uint32_t unread = newest - reader->last;
    /* The slot after the newest may be in work. */
    const uint32_t there = h->slots - 1 < newest ? h->slots - 1 : newest;
    const uint32_t number = in_order ? newest - (unread < there ? unread : there) + 1 : newest;
    const size_t slot = h->header_bytes + (size_t)(number % h->slots) * h->slot_bytes;
    if (newest == 0 || unread == 0) return 0;
    if (egofocus_depth_load_(reader, slot, __ATOMIC_ACQUIRE) != 2 * number) continue;
    egofocus_depth_copy_(reader, slot + EGOFOCUS_DEPTH_INFO_AT, info, sizeof *info);
    if (inverse_depth != NULL)
      egofocus_depth_copy_(reader, slot + h->inverse_depth_at, inverse_depth, 2 * pixels);
    if (confidence != NULL) egofocus_depth_copy_(reader, slot + h->confidence_at, confidence, pixels);
    __atomic_thread_fence(__ATOMIC_ACQUIRE);
    if (egofocus_depth_load_(reader, slot, __ATOMIC_RELAXED) != 2 * number) continue;
    if (in_order && reader->last != 0) reader->missed += number - reader->last - 1;
    reader->last = number;
    return 1;
  }
  return -EAGAIN; /* overwritten 16 times over while it was copied */
}

/* Copies the newest frame, if it is newer than the last one read: 1, else 0; -EAGAIN: this reader is so slow
 * that frames go by faster than it copies. Arrays hold egofocus_depth_pixels() elements; either may be NULL.
 */
static inline int egofocus_depth_newest(egofocus_depth_reader* reader, egofocus_depth_info* info,
                                        uint16_t* inverse_depth, uint8_t* confidence) {
  return egofocus_depth_read_(reader, 0, info, inverse_depth, confidence);
}

/* The same, but frame after frame, as long as they have not been overwritten: the last `slots` - 1 are there;
 * `missed` counts those that were gone. */
static inline int egofocus_depth_next(egofocus_depth_reader* reader, egofocus_depth_info* info,
                                      uint16_t* inverse_depth, uint8_t* confidence) {
  return egofocus_depth_read_(reader, 1, info, inverse_depth, confidence);
}

#ifdef __cplusplus
}
#endif

#endif
