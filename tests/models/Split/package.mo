package Split "Plants cut into two parts that exchange continuous signals, each beside the whole"
end Split;
