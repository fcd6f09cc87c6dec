#!/bin/sh
# Makes DejaVuSans-subset.ttf: the characters that labels of pictures use, without hinting.
# Usage: subset.sh /path/to/DejaVuSans.ttf    (needs fonttools' pyftsubset; made from version 2.37)
set -eu
latin='U+0020-007E,U+00A0,U+00B0-00B3,U+00B5,U+00B7,U+00B9,U+00BC-00BE,U+00D7,U+00E9,U+00F6,U+00FC'
greek='U+0393,U+0394,U+0398,U+039B,U+039E,U+03A0,U+03A3,U+03A6,U+03A8,U+03A9,U+03B1-03C9'
marks='U+2009,U+2013,U+2014,U+2019,U+201C,U+201D,U+2026,U+2032,U+2033,U+2070,U+2074-207B,U+2080-208B'
maths='U+2190-2194,U+21A6,U+21D2,U+2202,U+2207,U+2208,U+2211,U+2212,U+221A,U+221E,U+2225,U+2248,U+2260,U+2264,U+2265'
pyftsubset "$1" --unicodes="$latin,$greek,$marks,$maths" --output-file="$(dirname "$0")/DejaVuSans-subset.ttf" \
    --layout-features='' --legacy-kern --no-hinting --notdef-outline \
    --name-IDs=0,1,2,4,5,6,11,13,14 --name-languages=0x0409 --drop-tables+=GPOS,GSUB,GDEF,MATH,gasp
