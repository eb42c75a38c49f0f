// Nothing: of this program only the headers are of use, which are compiled beforehand.
