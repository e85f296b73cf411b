// Marks what the shared library exports; everything else stays hidden.
#pragma once

#define EGOFOCUS_API [[gnu::visibility("default")]]
